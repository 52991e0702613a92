"""Which CANopen node and object is which joint's encoder and analogue output.

The URL's ``nodes`` (or the device file's ``settings.nodes``) choose one of three usual layouts:
one node with both joints (multi-sensor objects), one node a joint, or two encoders and a node with
both outputs. ``settings.encoders`` and ``settings.outputs`` spell out any other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, cast

from cosim.base.errors import InputError
from cosim.base.show import show
from hil.drivers.canopen.protocol import LAST_NODE, LOGICAL_DEVICE, Index, Object
from hil.setup.address import Address
from hil.setup.device_file import DeviceFile

SETTINGS = (
    "absolute",
    "encoders",
    "heartbeat",
    "nodes",
    "outputs",
    "preset",
    "timeout",
    "watchdog",
)
"""What ``settings`` of a canopen device file may hold."""


@dataclass(frozen=True, slots=True)
class Encoder:
    """A joint's position value."""

    node: int
    position: Object
    preset: Object

    @property
    def units_per_turn(self) -> Object:
        """Measuring units per revolution, of the logical device that it belongs to."""
        return Object(Index.UNITS_PER_TURN + _logical(self.position), 0, 4)

    @property
    def range(self) -> Object:
        """Total measuring range in measuring units, after which positions begin anew."""
        return Object(Index.RANGE + _logical(self.position), 0, 4)


@dataclass(frozen=True, slots=True)
class Output:
    """A joint's analogue output."""

    node: int
    value: Object

    @property
    def error_mode(self) -> Object:
        """What it does on an error: 1 takes the error value, 0 holds."""
        return self._beside(Index.OUTPUT_ERROR_MODE, 1)

    @property
    def error_value(self) -> Object:
        """What it gives then."""
        return self._beside(Index.OUTPUT_ERROR_VALUE, 4)

    def _beside(self, index: Index, size: int) -> Object:
        return Object(index + _logical(self.value), self.value.subindex, size)


@dataclass(frozen=True, slots=True)
class Layout:
    """Encoders and outputs, joint by joint."""

    encoders: tuple[Encoder, Encoder]
    outputs: tuple[Output, Output]

    @property
    def nodes(self) -> tuple[int, ...]:
        """Every node, in the order of the bus's priorities."""
        return tuple(sorted({each.node for each in (*self.encoders, *self.outputs)}))

    @property
    def measuring(self) -> tuple[int, ...]:
        """Nodes with encoders."""
        return tuple(sorted({each.node for each in self.encoders}))

    @property
    def driving(self) -> tuple[int, ...]:
        """Nodes with outputs."""
        return tuple(sorted({each.node for each in self.outputs}))

    def joints_measured(self, node: int) -> tuple[int, ...]:
        """Joints in the order of a node's transmit PDO."""
        return tuple(joint for joint in (0, 1) if self.encoders[joint].node == node)

    def joints_driven(self, node: int) -> tuple[int, ...]:
        """Joints in the order of a node's receive PDO."""
        return tuple(joint for joint in (0, 1) if self.outputs[joint].node == node)

    @property
    def frames(self) -> tuple[int, ...]:
        """Data bytes of each frame of a tick, besides SYNC."""
        positions = [4 * len(self.joints_measured(node)) for node in self.measuring]
        codes = [2 * len(self.joints_driven(node)) for node in self.driving]
        return (*positions, *codes)


def layout(address: Address, file: DeviceFile) -> Layout:
    """The layout of a device.

    Raises:
        InputError: a node or an object cannot be one, or a setting is unknown.
    """
    _known("settings", file.settings, SETTINGS)
    written = address.options.get("nodes")
    nodes = _nodes(file.settings.get("nodes", [1]) if written is None else written.split(","))
    usual = _usual(nodes)
    encoders, outputs = file.settings.get("encoders"), file.settings.get("outputs")
    return Layout(
        usual.encoders if encoders is None else _two("encoders", encoders, _encoder),
        usual.outputs if outputs is None else _two("outputs", outputs, _output),
    )


def _usual(nodes: tuple[int, ...]) -> Layout:
    if len(nodes) == 1:
        (node,) = nodes
        return Layout(
            (_multi_sensor(node, 1), _multi_sensor(node, 2)),
            (_channel(node, 1), _channel(node, 2)),
        )
    first, second = _single_sensor(nodes[0]), _single_sensor(nodes[1])
    if len(nodes) == 2:
        return Layout((first, second), (_channel(nodes[0], 1), _channel(nodes[1], 1)))
    return Layout((first, second), (_channel(nodes[2], 1), _channel(nodes[2], 2)))


def _multi_sensor(node: int, channel: int) -> Encoder:
    position = Object(Index.POSITIONS, channel, 4)
    return Encoder(node, position, Object(Index.PRESETS, channel, 4))


def _single_sensor(node: int) -> Encoder:
    return Encoder(node, Object(Index.POSITION, 0, 4), Object(Index.PRESET, 0, 4))


def _channel(node: int, channel: int) -> Output:
    return Output(node, Object(Index.OUTPUT, channel, 2))


def _encoder(where: str, values: Mapping[str, Any]) -> Encoder:
    _known(where, values, ("node", "object", "channel"))
    index = _whole(f"{where}.object", values.get("object", Index.POSITION), 0x6000, 0x9FFF)
    channel = _whole(f"{where}.channel", values.get("channel", 0), 0, 254)
    preset = Index.PRESET - Index.POSITION if channel == 0 else Index.PRESETS - Index.POSITIONS
    position = Object(index, channel, 4)
    node = _whole(f"{where}.node", values.get("node"), 1, LAST_NODE)
    return Encoder(node, position, Object(index + preset, channel, 4))


def _output(where: str, values: Mapping[str, Any]) -> Output:
    _known(where, values, ("node", "object", "channel"))
    index = _whole(f"{where}.object", values.get("object", Index.OUTPUT), 0x6000, 0x9FFF)
    channel = _whole(f"{where}.channel", values.get("channel", 1), 1, 254)
    node = _whole(f"{where}.node", values.get("node"), 1, LAST_NODE)
    return Output(node, Object(index, channel, 2))


def _two(name: str, document: object, one: Any) -> Any:
    entries = cast("list[object]", document) if isinstance(document, list) else []
    if len(entries) != 2 or not all(isinstance(entry, Mapping) for entry in entries):
        raise InputError(f"'settings.{name}' has to be a list of two mappings, one a joint")
    first, second = (
        one(f"settings.{name}[{number}]", entry) for number, entry in enumerate(entries, start=1)
    )
    if first == second:
        raise InputError(f"'settings.{name}' gives both joints the same object of the same node")
    return first, second


def _nodes(values: Any) -> tuple[int, ...]:
    listed = cast("list[object]", values if isinstance(values, list) else [values])
    if len(listed) not in {1, 2, 3}:
        raise InputError(
            "'nodes' of a canopen device are one node with both joints, two with one each, or two "
            f"encoders and a node with both outputs; {len(listed)} are given"
        )
    found = tuple(_whole("nodes", _number(value), 1, LAST_NODE) for value in listed)
    if len(set(found)) != len(found):
        raise InputError(f"'nodes={','.join(map(str, found))}' names a node twice")
    return found


def _number(value: object) -> object:
    try:
        return int(value, 0) if isinstance(value, str) else value
    except ValueError:
        return value


def _whole(where: str, value: object, least: int, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError(
            f"'{where}' has to be a whole number from {least:#x} to {most:#x}, it is {show(value)}"
            if least > LAST_NODE
            else f"'{where}' has to be a whole number from {least} to {most}, it is {show(value)}"
        )
    return int(value)


def _known(where: str, values: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for name in values:
        if name not in known:
            close = get_close_matches(name, known, 1)
            hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(known)}"
            raise InputError(f"unknown entry '{name}' in {where}; {hint}")


def _logical(entry: Object) -> int:
    """Where the profile area of an object's logical device begins, from that of the first."""
    return (entry.index - 0x6000) // LOGICAL_DEVICE * LOGICAL_DEVICE
