"""The framed protocol of boards that measure: a question each tick, an answer with raw counts.

Frames and their checksum are those of ``hil.wire.cobs_frames``; all else is little-endian. None of
the questions carries a command, and a board has nothing that it could do about one.

Ask (4 bytes and CRC): kind 0x02, 0, sequence u16. Answer: kind 0x82, status, sequence of the
question u16, device time u32 (us), channels at the end of their range (bits) u8, number of channels
u8, counts i32 each, CRC. Who (4 bytes and CRC): kind 0x03, 0, sequence u16. Answer (10 bytes and
CRC): kind 0x83, number of channels, sequence u16, protocol version u16, serial number u32.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntFlag

from hil.wire.cobs_frames import frame

ASK, ANSWER, WHO, IDENTITY = 0x02, 0x82, 0x03, 0x83
VERSION = 1
MOST_CHANNELS = 6
_QUESTION = struct.Struct("<BBH")
_ANSWER = struct.Struct("<BBHIBB")
_IDENTITY = struct.Struct("<BBHHI")


class AnswerFlag(IntFlag):
    """What the board says of itself."""

    BROWN_OUT = 1
    """The bridges' supply was too low since the last answer: these counts mean nothing."""
    FAULT = 2
    """A converter does not answer the board, or another error of its own."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a board measured."""

    status: AnswerFlag
    sequence: int
    microseconds: int
    clipped: frozenset[int]
    """Channels that stood at the end of their range."""
    counts: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Identity:
    """What a board is."""

    channels: int
    sequence: int
    version: int
    serial: int


def ask(sequence: int) -> bytes:
    """The frame that asks for a sample."""
    return frame(_QUESTION.pack(ASK, 0, sequence & 0xFFFF))


def who(sequence: int) -> bytes:
    """The frame that asks which board it is."""
    return frame(_QUESTION.pack(WHO, 0, sequence & 0xFFFF))


def answer(data: bytes) -> Answer | None:
    """The answer in a payload, or ``None`` where it is something else."""
    if len(data) < _ANSWER.size or data[0] != ANSWER:
        return None
    _, status, sequence, microseconds, clipped, number = _ANSWER.unpack_from(data)
    if not 1 <= number <= MOST_CHANNELS or len(data) != _ANSWER.size + 4 * number:
        return None
    return Answer(
        AnswerFlag(status),
        sequence,
        microseconds,
        frozenset(index for index in range(8) if clipped >> index & 1),
        struct.unpack_from(f"<{number}i", data, _ANSWER.size),
    )


def identity(data: bytes) -> Identity | None:
    """The identity in a payload, or ``None`` where it is something else."""
    if len(data) != _IDENTITY.size or data[0] != IDENTITY:
        return None
    _, channels, sequence, version, serial = _IDENTITY.unpack(data)
    return Identity(channels, sequence, version, serial)
