"""One CANopen node with two encoders (CiA 406) and two amplifiers on analogue outputs (CiA 401).

Expedited SDO alone, one TPDO at each SYNC, one RPDO taken over as it comes, heartbeats. What is in
its PDOs is read from its dictionary, where the master wrote it.
"""

from __future__ import annotations

import struct

from tests.support.hil.motors.slcan import Lines, line
from tests.support.hil.motors.told import Told

NODE = 1
COUNTS = 20000
VOLTS_PER_CODE, TORQUE_PER_VOLT = 10 / 32767, 0.0182
"""Of a DAC for 10 V; of a motor of 36.4 mN.m/A behind an amplifier of 0.5 A/V."""
OUTPUTS = ((0x6411, 1), (0x6411, 2))
OPERATIONAL, PRE_OPERATIONAL = 5, 127
INVALID = 1 << 31
SIZES = {0x1001: 1, 0x1017: 2, 0x1029: 1, 0x6411: 2, 0x6443: 1}
"""Bytes of an object's entries; 4 unless they stand here."""
DICTIONARY = {
    (0x1001, 0): 0,
    (0x1016, 1): 0,
    (0x1017, 0): 0,
    (0x1018, 4): 4712,
    (0x1029, 1): 0,
    (0x6001, 0): COUNTS,
    (0x6002, 0): COUNTS * 4096,
    **{(index, channel): 0 for index in (0x6010, 0x6020, 0x6411) for channel in (1, 2)},
    **{(index, channel): 0 for index in (0x6443, 0x6444) for channel in (1, 2)},
    (0x1400, 1): 0x200 + NODE,
    (0x1400, 2): 255,
    (0x1800, 1): 0x180 + NODE,
    (0x1800, 2): 255,
    **{(index, entry): 0 for index in (0x1600, 0x1A00) for entry in range(5)},
}


class Canopen:
    """Both shafts stand where their preset says."""

    def __init__(self) -> None:
        self.lines = Lines()
        self.state = PRE_OPERATIONAL
        self.entries = dict(DICTIONARY)
        self.zeros: set[tuple[int, int]] = set()
        """Outputs that were read as zero since a torque came."""
        self.since_beat = 0
        self.heard: int | None = None
        """Ticks since the master's heartbeat, once it has come."""
        self.missed = False

    def feed(self, data: bytes) -> list[Told]:
        found: list[Told] = []
        for identifier, content in self.lines.frames(data):
            if identifier == 0x000 and content[1] in {0, NODE}:
                found += self.command(content[0])
            elif identifier == 0x080 and not content:
                found += self.sync()
            elif identifier == self.entries[0x1400, 1] & 0x7FF:
                found += self.take(content)
            elif identifier == 0x600 + NODE:
                found += self.serve(content)
            elif identifier == 0x700 + (self.entries[0x1016, 1] >> 16 & 0x7F):
                self.heard, self.missed = 0, False
        return found

    def tick(self) -> list[Told]:
        found: list[Told] = []
        self.since_beat += 1
        if self.entries[0x1017, 0] and self.since_beat >= self.entries[0x1017, 0]:
            self.since_beat = 0
            found.append(Told(answer=line(0x700 + NODE, bytes([self.state]))))
        limit = self.entries[0x1016, 1] & 0xFFFF
        if self.heard is not None and limit and not self.missed:
            self.heard += 1
            if self.heard > limit:
                self.missed, self.state = True, PRE_OPERATIONAL
                found.append(Told(answer=line(0x080 + NODE, struct.pack("<HB5x", 0x8130, 0x11))))
        return found

    def command(self, which: int) -> list[Told]:
        if which in {129, 130}:
            self.entries = dict(DICTIONARY)
            self.state, self.heard, self.missed = PRE_OPERATIONAL, None, False
            return [Told(self.torques(), line(0x700 + NODE, b"\0"))]
        self.state = {1: OPERATIONAL, 2: 4, 128: PRE_OPERATIONAL}.get(which, self.state)
        return []

    def sync(self) -> list[Told]:
        name = self.entries[0x1800, 1]
        if self.state != OPERATIONAL or name & INVALID or self.entries[0x1800, 2] != 1:
            return []
        content = b"".join(
            self.entries[place].to_bytes(size, "little") for place, size in self.mapped(0x1A00)
        )
        return [Told(answer=line(name & 0x7FF, content))]

    def take(self, content: bytes) -> list[Told]:
        if self.state != OPERATIONAL or self.entries[0x1400, 1] & INVALID:
            return []
        for place, size in self.mapped(0x1600):
            self.entries[place] = int.from_bytes(content[:size], "little")
            content = content[size:]
        return [Told(self.told())]

    def mapped(self, index: int) -> list[tuple[tuple[int, int], int]]:
        entries = [self.entries[index, n] for n in range(1, self.entries[index, 0] + 1)]
        return [((entry >> 16, entry >> 8 & 0xFF), (entry & 0xFF) // 8) for entry in entries]

    def serve(self, request: bytes) -> list[Told]:
        """Expedited SDO: 0x40 reads, 0x2X writes."""
        command, *place, value = struct.unpack("<BHBI", request)
        key = (place[0], place[1])
        if key not in self.entries:
            return [self.answer(0x80, key, 0x06020000)]
        size = SIZES.get(key[0], 1 if key[1] == 0 and key[0] in {0x1600, 0x1A00} else 4)
        if key in {(0x1400, 2), (0x1800, 2)}:
            size = 1
        if command == 0x40:
            read = self.entries[key] & ((1 << 8 * size) - 1)
            self.zeros |= {key} if key in OUTPUTS and read == 0 else set()
            confirms = self.zeros == set(OUTPUTS)
            if confirms:
                self.zeros.clear()
            return [self.answer(0x43 | (4 - size) << 2, key, read, zero=confirms)]
        self.entries[key] = value & ((1 << 8 * size) - 1)
        if key[0] == 0x6010:
            self.entries[0x6020, key[1]] = self.entries[key]
        if key == (0x1016, 1):
            self.heard, self.missed = None, False
        told = Told(self.told()) if key in OUTPUTS else Told()
        return [told, self.answer(0x60, key, 0)]

    def answer(self, command: int, key: tuple[int, int], value: int, *, zero: bool = False) -> Told:
        content = struct.pack("<BHBI", command, *key, value)
        return Told(answer=line(0x580 + NODE, content), zero=zero)

    def told(self) -> tuple[float, ...]:
        found = self.torques()
        if any(found):
            self.zeros.clear()
        return found

    def torques(self) -> tuple[float, ...]:
        codes = [(self.entries[place] ^ 0x8000) - 0x8000 for place in OUTPUTS]
        return tuple(code * VOLTS_PER_CODE * TORQUE_PER_VOLT for code in codes)
