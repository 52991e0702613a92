"""Our own serial protocol for home-made boards: COBS frames with CRC-16 and sequence numbers.

Frames and their checksum are those of ``hil.wire.cobs_frames``; all else is little-endian.

Command (16 bytes, 18 on the wire): kind 0x01, flags, sequence u16, torque f32 x 2 (N.m), watchdog
u16 (ms), CRC. Reply (20 bytes, 22 on the wire): kind 0x81, status, sequence of the command it
answers u16, device time u32 (us), counts i32 x 2, 0 u16, CRC.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntFlag

from hil.device.errors import ProtocolError
from hil.safety.linkage import Pair
from hil.wire.cobs_frames import frame

COMMAND, REPLY = 0x01, 0x81
_COMMAND = struct.Struct("<BBHffH")
_REPLY = struct.Struct("<BBHIiiH")


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


_KNOWN = sum(ReplyFlag)


@dataclass(frozen=True, slots=True)
class Reply:
    """What a board answers."""

    status: ReplyFlag
    sequence: int
    microseconds: int
    count: tuple[int, int]


def command(flags: CommandFlag, sequence: int, torque: Pair, watchdog_ms: int) -> bytes:
    """A command's frame (18 bytes)."""
    return frame(_COMMAND.pack(COMMAND, flags, sequence & 0xFFFF, *torque, watchdog_ms))


def reply(data: bytes) -> Reply | None:
    """The reply in a payload, or ``None`` where it is something else.

    Raises:
        ProtocolError: it says what no board of this protocol says.
    """
    if len(data) != _REPLY.size or data[0] != REPLY:
        return None
    _, status, sequence, microseconds, first, second, spare = _REPLY.unpack(data)
    if status & ~_KNOWN or spare:
        raise ProtocolError(
            f"a reply with status 0x{status:02x} and a spare field of {spare}: the board speaks "
            "another version of the protocol; renew its firmware"
        )
    return Reply(ReplyFlag(status), sequence, microseconds, (first, second))
