"""What an emulated CANopen node of any profile does: NMT, process data, supervision, mappings.

SDO, NMT and emergencies are the package's (``emulated_local``). Process data, heartbeat consumer
and error behaviour are written here from the dictionary, without the driver's functions: what a
master set up by SDO is what the PDOs then carry.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from canopen.sdo.exceptions import SdoAbortedError

from hil.drivers.canopen.emulated_local import Local, LocalWire
from hil.emulation.board import BoardFrame, Unit

HEARTBEAT_MISSING, COMMUNICATION_ERROR = 0x8130, 0x11
"""Emergency and error register (generic and communication)."""
_INVALID = 1 << 31


class MappedNode(ABC):
    """One node on the bus; ``mappable`` are objects, sub-indices and bits that a PDO may carry."""

    mappable: frozenset[tuple[int, int, int]] = frozenset()
    entries = 2
    """Objects that a PDO may carry at most."""

    def __init__(self, number: int, local: Local, wire: LocalWire) -> None:
        self._wire = wire
        self.local: Any = local
        self.value: Callable[[int, int], int] = local.value
        self.failed = False
        self._heard: float | None = None
        self._waiting: list[tuple[int, bytes]] = []
        """What a synchronous RPDO brought for the next SYNC."""
        wire[number] = local

    @abstractmethod
    def drive(self) -> None:
        """The output stage follows the dictionary, or what an error asks for."""

    @abstractmethod
    def torque(self) -> dict[int, float]:
        """Torque by joint that its output stage gives (N.m)."""

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
                frames.append(BoardFrame(identifier & 0x7FF, self._packed(0x1A00 + number)))
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

    def _check_mapping(self, index: int, subindex: int, value: int) -> None:
        """A mapping changes only while its PDO is invalid and counts no entries (CiA 301)."""
        valid = not self.value(index - 0x200, 1) & _INVALID
        if valid or (subindex and self.value(index, 0)):
            raise SdoAbortedError(0x08000022)
        if subindex and (value >> 16, value >> 8 & 0xFF, value & 0xFF) not in self.mappable:
            raise SdoAbortedError(0x06040041)
        if not subindex and value > self.entries:
            raise SdoAbortedError(0x06040042)
