"""Our own serial protocol for home-made boards: COBS frames with CRC-16 and sequence numbers.

A frame is COBS(payload + CRC) and a zero byte, so a reader is back in step at the next zero byte
whatever was lost. CRC-16/CCITT-FALSE (polynomial 0x1021, initial 0xFFFF), high byte first, because
only in that order does it notice every burst of up to 16 bits that reaches into it; all else is
little-endian. Source of COBS: S. Cheshire and M. Baker, IEEE/ACM Trans. Networking 7(2), 1999.

Command (16 bytes, 18 on the wire): kind 0x01, flags, sequence u16, torque f32 x 2 (N.m), watchdog
u16 (ms), CRC. Reply (20 bytes, 22 on the wire): kind 0x81, status, sequence of the command it
answers u16, device time u32 (us), counts i32 x 2, age of the torque u16 (ms), CRC.
"""

from __future__ import annotations

import binascii
import struct
from dataclasses import dataclass
from enum import IntFlag

from hil.safety.linkage import Pair

COMMAND, REPLY = 0x01, 0x81
_COMMAND = struct.Struct("<BBHffH")
_REPLY = struct.Struct("<BBHIiiH")
CRC_BYTES = 2
LONGEST_FRAME = 64
"""More bytes than this without a zero byte are noise."""


class CommandFlag(IntFlag):
    """What a command asks for besides torque."""

    ENABLE = 1
    """Drive the motors; without it they are without torque."""
    CLEAR = 2
    """Forget a watchdog that fired."""


class ReplyFlag(IntFlag):
    """What the board says of itself."""

    ENABLED = 1
    WATCHDOG_FIRED = 2
    ZERO = 4
    """The output stage really is at zero."""
    FAULT = 8
    INPUT = 16
    """The switch on the board is closed: its dead-man input is held."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What a board answers."""

    status: ReplyFlag
    sequence: int
    microseconds: int
    count: tuple[int, int]


def crc(data: bytes) -> int:
    """CRC-16/CCITT-FALSE; of "123456789" it is 0x29B1."""
    return binascii.crc_hqx(data, 0xFFFF)


def stuff(data: bytes) -> bytes:
    """COBS without the closing zero byte; at most 254 bytes."""
    parts = data.split(b"\0")
    return b"".join(bytes((len(part) + 1,)) + part for part in parts)


def unstuff(data: bytes) -> bytes | None:
    """What was stuffed, or ``None`` where it cannot have been."""
    plain = bytearray()
    place = 0
    while place < len(data):
        size = data[place]
        if size == 0 or place + size > len(data):
            return None
        plain += data[place + 1 : place + size]
        place += size
        if place < len(data):
            plain.append(0)
    return bytes(plain) if data else None


def frame(payload: bytes) -> bytes:
    """A whole frame with its checksum and the closing zero byte."""
    return stuff(payload + struct.pack(">H", crc(payload))) + b"\0"


def payload(stuffed: bytes) -> bytes | None:
    """The payload between two zero bytes, or ``None`` where its checksum does not fit."""
    data = unstuff(stuffed)
    if data is None or len(data) <= CRC_BYTES:
        return None
    body, (given,) = data[:-CRC_BYTES], struct.unpack(">H", data[-CRC_BYTES:])
    return body if crc(body) == given else None


def command(flags: CommandFlag, sequence: int, torque: Pair, watchdog_ms: int) -> bytes:
    """A command's frame (18 bytes)."""
    return frame(_COMMAND.pack(COMMAND, flags, sequence & 0xFFFF, *torque, watchdog_ms))


def reply(data: bytes) -> Reply | None:
    """The reply in a payload, or ``None`` where it is something else."""
    if len(data) != _REPLY.size or data[0] != REPLY:
        return None
    _, status, sequence, microseconds, first, second, _ = _REPLY.unpack(data)
    return Reply(ReplyFlag(status), sequence, microseconds, (first, second))


class Splitter:
    """Payloads out of a stream of bytes; what is damaged is counted and left out."""

    def __init__(self) -> None:
        self._pending = b""
        self.damaged = 0

    def feed(self, data: bytes) -> list[bytes]:
        """The whole, valid payloads that end in ``data``."""
        *whole, self._pending = (self._pending + data).split(b"\0")
        if len(self._pending) > LONGEST_FRAME:
            self._pending, self.damaged = self._pending[-LONGEST_FRAME:], self.damaged + 1
        found: list[bytes] = []
        for stuffed in whole:
            body = payload(stuffed) if stuffed else None
            if body is not None:
                found.append(body)
            elif stuffed:
                self.damaged += 1
        return found
