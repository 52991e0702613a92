"""CANopen nodes with encoders (CiA 406) and analogue outputs (CiA 401), as a master sees them.

The SDO server, the NMT slave and the emergencies are those of the PyPI package ``canopen``; process
data, heartbeat consumer and error behaviour are written here from the object dictionary, without
the driver's functions: what a master set up by SDO is what the PDOs then carry.
"""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi
from typing import Any

import canopen
from canopen.sdo.exceptions import SdoAbortedError, SdoError

from hil.emulators.board import Board, Frame, Unit
from hil.emulators.canopen_objects import dictionary
from hil.emulators.faults import FaultKind
from hil.emulators.world import World

SYNC = 0x080
TORQUE_PER_CODE = 10.0 / 32767 * 0.5 * 0.0364
"""A DAC of +-10 V, an amplifier of 0.5 A/V and a motor of 0.0364 N.m/A (N.m)."""
ENTRIES = 2
MAPPABLE = {(0, 0, 0), (0x6004, 0, 32), (0x6020, 1, 32), (0x6020, 2, 32)} | {
    (0x6411, 1, 16),
    (0x6411, 2, 16),
}
"""Objects with sub-index and bits that a PDO may carry, at most so many of them."""
LARGEST_CODE = 32767
HEARTBEAT_MISSING, HARDWARE = 0x8130, 0x5000
COMMUNICATION_ERROR, HARDWARE_ERROR = 0x11, 0x81
"""Error register: generic, with communication or manufacturer specific."""
_INVALID = 1 << 31


@dataclass
class _Periodic:
    """A heartbeat that the NMT slave wants to have sent; the board's clock does it."""

    identifier: int
    data: bytes
    period: float
    due: float = 0.0
    stopped: bool = False

    def update(self, data: Any) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self.stopped = True


class _Wire(canopen.Network):
    """What the package's local nodes send into; no bus and no thread behind it."""

    def __init__(self) -> None:
        super().__init__()
        self.frames: list[Frame] = []
        self.periodic: list[_Periodic] = []

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        self.frames.append(Frame(can_id, bytes(data)))

    def send_periodic(
        self,
        can_id: int,
        data: Any,
        period: float,
        remote: bool = False,
    ) -> Any:
        made = _Periodic(can_id, bytes(data), period)
        self.periodic.append(made)
        return made

    def taken(self) -> list[Unit]:
        frames, self.frames = self.frames, []
        return [*frames]


class _Local(canopen.LocalNode):
    """The package's local node, which remembers the values that every tick needs."""

    def __init__(self, number: int) -> None:
        super().__init__(number, dictionary(number))
        self._known: dict[tuple[int, int], int] = {}

    def value(self, index: int, subindex: int) -> int:
        """A number of the dictionary (not a position, which changes by itself)."""
        place = index, subindex
        if place not in self._known:
            variable: Any = self.object_dictionary.get_variable(index, subindex)
            self._known[place] = int(variable.decode_raw(self.get_data(index, subindex)))
        return self._known[place]

    def set_data(self, index: int, subindex: int, data: Any, check_writable: Any = False) -> None:
        super().set_data(index, subindex, data, check_writable)
        self._known.pop((index, subindex), None)

    def forget(self) -> None:
        """Everything is as after power-on."""
        self.data_store.clear()
        self._known.clear()


@dataclass
class Axes:
    """Which joints a node's channels belong to: object -> joint."""

    positions: dict[tuple[int, int], int] = field(default_factory=dict[tuple[int, int], int])
    outputs: dict[int, int] = field(default_factory=dict[int, int])
    """Sub-index of 6411h -> joint."""


def axes(nodes: tuple[int, ...]) -> dict[int, Axes]:
    """One node with both joints, one a joint, or two encoders and a node with both outputs."""
    match nodes:
        case (both,):
            return {both: Axes({(0x6020, 1): 0, (0x6020, 2): 1}, {1: 0, 2: 1})}
        case (first, second):
            return {
                first: Axes({(0x6004, 0): 0}, {1: 0}),
                second: Axes({(0x6004, 0): 1}, {1: 1}),
            }
        case _:
            first, second, outputs = nodes
            return {
                first: Axes({(0x6004, 0): 0}),
                second: Axes({(0x6004, 0): 1}),
                outputs: Axes({}, {1: 0, 2: 1}),
            }


class Node:
    """One node on the bus."""

    def __init__(self, number: int, its: Axes, wire: _Wire, world: World) -> None:
        self.its, self._world, self._wire = its, world, wire
        self.local: Any = _Local(number)
        self.value: Callable[[int, int], int] = self.local.value
        self.local.add_read_callback(self._read)
        self.local.add_write_callback(self._write)
        wire[number] = self.local
        self.failed = False
        self.driven = dict.fromkeys(its.outputs, 0)
        """What the output stage gives (codes)."""
        self._zero = dict.fromkeys(its.positions, 0)
        self._heard: float | None = None
        self._waiting: list[tuple[int, bytes]] = []
        """What a synchronous RPDO brought for the next SYNC."""
        self.boot()

    @property
    def operational(self) -> bool:
        """Whether process data is exchanged."""
        return self.local.nmt.state == "OPERATIONAL"

    def boot(self) -> None:
        """Start as after power-on (the encoder keeps its zero)."""
        self.local.forget()
        self.local.nmt.stop_heartbeat()
        self.failed, self._heard = False, None
        self.local.nmt.send_command(0x81)
        self.local.nmt.send_command(0x80)
        self.drive()

    def report(self, code: int, register: int) -> None:
        """Send an emergency and remember it."""
        self.failed = True
        self.local.set_data(0x1001, 0, bytes((register,)))
        self.local.emcy.send(code, register)

    def take(self, data: bytes) -> None:
        """A receive PDO came."""
        kind = self.value(0x1400, 2)
        if not self.operational or self.value(0x1400, 1) & _INVALID:
            return
        if kind <= 240:
            self._waiting.append((kind, data))
        else:
            self._unpack(data)

    def sync(self) -> list[Unit]:
        """Apply what waited for it, sample, and send what it is mapped to."""
        waiting, self._waiting = self._waiting, []
        if not self.operational:
            return []
        for _, data in waiting:
            self._unpack(data)
        frames: list[Unit] = []
        for number in (0, 1):
            identifier = self.value(0x1800 + number, 1)
            if not identifier & _INVALID and 1 <= self.value(0x1800 + number, 2) <= 240:
                frames.append(Frame(identifier & 0x7FF, self._packed(0x1A00 + number)))
        return frames

    def hear(self, producer: int, now: float) -> None:
        """A heartbeat of another node."""
        if self.value(0x1016, 1) >> 16 & 0x7F != producer:
            return
        if self._heard is not None and self.failed and self.value(0x1001, 0) == COMMUNICATION_ERROR:
            self.failed = False
            self.local.set_data(0x1001, 0, b"\0")
            self.local.emcy.reset()
        self._heard = now

    def listen(self, now: float) -> None:
        """Time passes: is the master's heartbeat still there?"""
        limit = (self.value(0x1016, 1) & 0xFFFF) * 1e-3
        if self._heard is None or self.failed or not limit or now - self._heard <= limit:
            return
        self.report(HEARTBEAT_MISSING, COMMUNICATION_ERROR)
        behaviour = self.value(0x1029, 1)
        if behaviour == 0 and self.operational:
            self.local.nmt.send_command(0x80)
        elif behaviour == 2:
            self.local.nmt.send_command(0x02)

    def drive(self) -> None:
        """The output stage follows the dictionary, or its error mode."""
        for channel in self.driven:
            if not self.failed and self.local.nmt.state != "STOPPED":
                self.driven[channel] = self.value(0x6411, channel)
            elif self.value(0x6443, channel):
                wanted = self.value(0x6444, channel)
                self.driven[channel] = max(-LARGEST_CODE, min(LARGEST_CODE, wanted))

    def _mapped(self, mapping: int) -> list[tuple[int, int, int]]:
        """Index, sub-index and bytes of what a PDO carries."""
        entries = [self.value(mapping, n + 1) for n in range(self.value(mapping, 0))]
        return [(entry >> 16, entry >> 8 & 0xFF, (entry & 0xFF) // 8) for entry in entries if entry]

    def _packed(self, mapping: int) -> bytes:
        parts = (
            self.local.get_data(index, subindex) for index, subindex, _ in self._mapped(mapping)
        )
        return b"".join(parts)[:8]

    def _unpack(self, data: bytes) -> None:
        entries = self._mapped(0x1600)
        if len(data) < sum(size for _, _, size in entries):
            return
        for index, subindex, size in entries:
            self.local.set_data(index, subindex, data[:size])
            data = data[size:]

    def _read(self, index: int, subindex: int, **_: Any) -> int | None:
        joint = self.its.positions.get((index, subindex))
        if joint is None:
            return None
        span = self.value(0x6002, 0) or 1 << 32
        return (self._count(joint) + self._zero[index, subindex]) % span

    def _count(self, joint: int) -> int:
        return round(self._world.angle()[joint] / (2 * pi) * self.value(0x6001, 0))

    def _write(self, index: int, subindex: int, data: bytes, **_: Any) -> None:
        if 0x1A00 <= index <= 0x1A01 or index == 0x1600:
            self._check_mapping(index, subindex, int.from_bytes(data, "little"))
        if index == 0x1016:
            self._heard = None
        place = {0x6003: (0x6004, 0), 0x6010: (0x6020, subindex)}.get(index)
        if place in self.its.positions:
            (wanted,) = struct.unpack("<i", data)
            self._zero[place] = wanted - self._count(self.its.positions[place])

    def _check_mapping(self, index: int, subindex: int, value: int) -> None:
        """A mapping changes only while its PDO is invalid and counts no entries (CiA 301)."""
        valid = not self.value(index - 0x200, 1) & _INVALID
        if valid or (subindex and self.value(index, 0)):
            raise SdoAbortedError(0x08000022)
        if subindex and (value >> 16, value >> 8 & 0xFF, value & 0xFF) not in MAPPABLE:
            raise SdoAbortedError(0x06040041)
        if not subindex and value > ENTRIES:
            raise SdoAbortedError(0x06040042)


class CanopenBoard(Board):
    """Everything of ours on the bus."""

    def __init__(
        self, world: World, *, nodes: tuple[int, ...] = (1,), tick: float = 1 / 1024
    ) -> None:
        super().__init__(world)
        self._wire, self._tick, self._time = _Wire(), tick, 0.0
        self._nodes = {
            number: Node(number, its, self._wire, world) for number, its in axes(nodes).items()
        }
        self._wire.taken()  # nobody was there to see the nodes boot
        self._had: set[int] = set()

    def owns(self, identifier: int) -> bool:
        """Whether a frame is one that a node sends."""
        function, node = identifier & ~0x7F, identifier & 0x7F
        return node in self._nodes and function in {0x080, 0x180, 0x280, 0x580, 0x700}

    def receive(self, unit: Unit) -> list[Unit]:
        """Take one frame; SYNC ends the tick."""
        assert isinstance(unit, Frame)
        if unit.identifier == SYNC:
            self.world.boundary()
            answers = [frame for node in self._nodes.values() for frame in node.sync()]
        else:
            self._take(unit)
            answers = self._wire.taken()
        self._apply()
        return answers

    def tick(self) -> list[Unit]:
        """Heartbeats out, heartbeats missed, and what goes wrong by itself."""
        self._time += self._tick
        for node in self._nodes.values():
            node.listen(self._time)
        self._misbehave()
        self._wire.periodic = [each for each in self._wire.periodic if not each.stopped]
        for each in self._wire.periodic:
            each.due = each.due or self._time
            if self._time >= each.due:
                each.due += each.period
                self._wire.frames.append(Frame(each.identifier, each.data))
        self._apply()
        return self._wire.taken()

    def _take(self, frame: Frame) -> None:
        function, number = frame.identifier & ~0x7F, frame.identifier & 0x7F
        if function == 0x000 and len(frame.data) == 2:
            self._command(frame)
        elif function == 0x700:
            for node in self._nodes.values():
                node.hear(number, self._time)
        elif function == 0x200 and number in self._nodes:
            self._nodes[number].take(frame.data)
        elif function == 0x600 and len(frame.data) == 8:
            # The package's server stumbles over requests that make no sense; a node stays silent.
            with contextlib.suppress(struct.error, LookupError, ArithmeticError, SdoError):
                self._wire.notify(frame.identifier, bytearray(frame.data), self._time)

    def _command(self, frame: Frame) -> None:
        command, number = frame.data
        for each, node in self._nodes.items():
            if number not in (0, each):
                continue
            if command in (0x81, 0x82):
                node.boot()
            else:
                node.local.nmt.on_command(0, frame.data, self._time)

    def _misbehave(self) -> None:
        for kind in (FaultKind.RESTART, FaultKind.ALARM):
            fault = self.world.fault(kind)
            if fault is None or id(fault) in self._had:
                continue
            self._had.add(id(fault))
            for node in self._nodes.values():
                if kind is FaultKind.RESTART:
                    node.boot()
                else:
                    node.report(HARDWARE, HARDWARE_ERROR)

    def _apply(self) -> None:
        torque = [0.0, 0.0]
        for node in self._nodes.values():
            node.drive()
            for channel, joint in node.its.outputs.items():
                torque[joint] = node.driven[channel] * TORQUE_PER_CODE
        self.world.torque = (torque[0], torque[1])
