"""One CANopen node: expedited SDO alone, one PDO each way, heartbeats (CiA 301).

What is in its PDOs is read from its dictionary, where the master wrote it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from tests.support.hil.motors.slcan import line
from tests.support.hil.motors.told import Told

Key = tuple[int, int]
OPERATIONAL, PRE_OPERATIONAL = 5, 127
INVALID = 1 << 31
HEARTBEAT_MISSING = 0x8130
SIZES = {0x1001: 1, 0x1017: 2, 0x1029: 1}
"""Bytes of an object's entries; 4 unless they stand here."""


class Node:
    """``torques`` gives what all motors of the board are told now (N.m)."""

    def __init__(
        self,
        number: int,
        objects: dict[Key, int],
        sizes: dict[int, int],
        torques: Callable[[], tuple[float, ...]],
    ) -> None:
        self.number, self.torques = number, torques
        self.sizes = SIZES | sizes
        self.maker = {
            (0x1001, 0): 0,
            (0x1016, 1): 0,
            (0x1017, 0): 0,
            (0x1018, 4): 4711 + number,
            (0x1029, 1): 0,
            (0x1400, 1): 0x200 + number,
            (0x1400, 2): 255,
            (0x1800, 1): 0x180 + number,
            (0x1800, 2): 255,
            **{(index, entry): 0 for index in (0x1600, 0x1A00) for entry in range(5)},
            **objects,
        }
        self.since_beat = 0
        self.begin()

    def begin(self) -> None:
        """As after power-on."""
        self.entries = dict(self.maker)
        self.state = PRE_OPERATIONAL
        self.heard: int | None = None
        """Ticks since the master's heartbeat, once it has come."""
        self.missed = False

    # --- what a profile adds ---------------------------------------------------------------------

    def wrote(self, key: Key) -> bool:
        """An entry was written; whether a torque was told by that."""
        del key
        return False

    def confirms(self, key: Key) -> bool:
        """An entry was read; whether that says that the motors are at zero."""
        del key
        return False

    # --- frames ----------------------------------------------------------------------------------

    def hear(self, identifier: int, content: bytes) -> list[Told]:
        if identifier == 0x000 and content[1] in {0, self.number}:
            return self.command(content[0])
        if identifier == self.entries[0x1400, 1] & 0x7FF:
            return self.take(content)
        if identifier == 0x600 + self.number:
            return self.serve(content)
        if identifier == 0x700 + (self.entries[0x1016, 1] >> 16 & 0x7F):
            self.heard, self.missed = 0, False
        return []

    def tick(self) -> list[Told]:
        found: list[Told] = []
        self.since_beat += 1
        if self.entries[0x1017, 0] and self.since_beat >= self.entries[0x1017, 0]:
            self.since_beat = 0
            found.append(Told(answer=line(0x700 + self.number, bytes([self.state]))))
        limit = self.entries[0x1016, 1] & 0xFFFF
        if self.heard is not None and limit and not self.missed:
            self.heard += 1
            if self.heard > limit:
                self.missed, self.state = True, PRE_OPERATIONAL
                found.append(self.report(HEARTBEAT_MISSING))
        return found

    def report(self, code: int) -> Told:
        return Told(answer=line(0x080 + self.number, struct.pack("<HB5x", code, 0x11)))

    def command(self, which: int) -> list[Told]:
        if which in {129, 130}:
            self.begin()
            return [Told(self.torques(), line(0x700 + self.number, b"\0"))]
        self.state = {1: OPERATIONAL, 2: 4, 128: PRE_OPERATIONAL}.get(which, self.state)
        return []

    def sync(self) -> bytes:
        """Its answer to SYNC, if any."""
        name = self.entries[0x1800, 1]
        if self.state != OPERATIONAL or name & INVALID or self.entries[0x1800, 2] != 1:
            return b""
        content = b"".join(
            (self.entries[place] & ((1 << 8 * size) - 1)).to_bytes(size, "little")
            for place, size in self.mapped(0x1A00)
        )
        return line(name & 0x7FF, content)

    def take(self, content: bytes) -> list[Told]:
        if self.state != OPERATIONAL or self.entries[0x1400, 1] & INVALID:
            return []
        told = False
        for place, size in self.mapped(0x1600):
            self.entries[place] = int.from_bytes(content[:size], "little")
            content = content[size:]
            told |= self.wrote(place)
        return [Told(self.torques())] if told else []

    def mapped(self, index: int) -> list[tuple[Key, int]]:
        entries = [self.entries[index, n] for n in range(1, self.entries[index, 0] + 1)]
        return [((entry >> 16, entry >> 8 & 0xFF), (entry & 0xFF) // 8) for entry in entries]

    def size(self, key: Key) -> int:
        if key[1] == 0 and key[0] in {0x1600, 0x1A00}:
            return 1
        if key[0] in {0x1400, 0x1800} and key[1] != 1:
            return 1 if key[1] == 2 else 2
        return self.sizes.get(key[0], 4)

    def serve(self, request: bytes) -> list[Told]:
        """Expedited SDO: 0x40 reads, 0x2X writes."""
        command, *place, value = struct.unpack("<BHBI", request)
        key = (place[0], place[1])
        if key not in self.entries:
            return [self.answer(0x80, key, 0x06020000)]
        size = self.size(key)
        if command == 0x40:
            read = self.entries[key] & ((1 << 8 * size) - 1)
            return [self.answer(0x43 | (4 - size) << 2, key, read, zero=self.confirms(key))]
        self.entries[key] = value & ((1 << 8 * size) - 1)
        if key == (0x1016, 1):
            self.heard, self.missed = None, False
        told = [Told(self.torques())] if self.wrote(key) else []
        return [*told, self.answer(0x60, key, 0)]

    def answer(self, command: int, key: Key, value: int, *, zero: bool = False) -> Told:
        content = struct.pack("<BHBI", command, *key, value)
        return Told(answer=line(0x580 + self.number, content), zero=zero)


def signed(value: int, size: int) -> int:
    """Two's complement of so many bytes."""
    half = 1 << 8 * size - 1
    return ((value & 2 * half - 1) ^ half) - half
