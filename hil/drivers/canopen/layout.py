"""Which CANopen node and object is which joint's encoder and analogue output.

The URL's ``nodes`` (or the device file's ``settings.nodes``) choose one of three usual layouts:
one node with both joints (multi-sensor objects), one node a joint, or two encoders and a node with
both outputs. ``settings.encoders`` and ``settings.outputs`` spell out any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hil.drivers.canopen.protocol import LOGICAL_DEVICE, Index, Object

if TYPE_CHECKING:
    from hil.drivers.canopen.object_form import ObjectForm


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
class CanopenLayout:
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


def layout(
    nodes: tuple[int, ...],
    encoders: Sequence[ObjectForm] | None = None,
    outputs: Sequence[ObjectForm] | None = None,
) -> CanopenLayout:
    """The usual layout of one, two or three nodes, with what is spelled out in its place."""
    usual = _usual(nodes)
    return CanopenLayout(
        usual.encoders if encoders is None else (_encoder(encoders[0]), _encoder(encoders[1])),
        usual.outputs if outputs is None else (_output(outputs[0]), _output(outputs[1])),
    )


def _usual(nodes: tuple[int, ...]) -> CanopenLayout:
    if len(nodes) == 1:
        (node,) = nodes
        return CanopenLayout(
            (_multi_sensor(node, 1), _multi_sensor(node, 2)),
            (_channel(node, 1), _channel(node, 2)),
        )
    first, second = _single_sensor(nodes[0]), _single_sensor(nodes[1])
    if len(nodes) == 2:
        return CanopenLayout((first, second), (_channel(nodes[0], 1), _channel(nodes[1], 1)))
    return CanopenLayout((first, second), (_channel(nodes[2], 1), _channel(nodes[2], 2)))


def _multi_sensor(node: int, channel: int) -> Encoder:
    position = Object(Index.POSITIONS, channel, 4)
    return Encoder(node, position, Object(Index.PRESETS, channel, 4))


def _single_sensor(node: int) -> Encoder:
    return Encoder(node, Object(Index.POSITION, 0, 4), Object(Index.PRESET, 0, 4))


def _channel(node: int, channel: int) -> Output:
    return Output(node, Object(Index.OUTPUT, channel, 2))


def _encoder(form: ObjectForm) -> Encoder:
    index, channel = form.object or Index.POSITION, form.channel or 0
    preset = Index.PRESET - Index.POSITION if channel == 0 else Index.PRESETS - Index.POSITIONS
    return Encoder(form.node, Object(index, channel, 4), Object(index + preset, channel, 4))


def _output(form: ObjectForm) -> Output:
    channel = 1 if form.channel is None else form.channel
    return Output(form.node, Object(form.object or Index.OUTPUT, channel, 2))


def _logical(entry: Object) -> int:
    """Where the profile area of an object's logical device begins, from that of the first."""
    return (entry.index - 0x6000) // LOGICAL_DEVICE * LOGICAL_DEVICE
