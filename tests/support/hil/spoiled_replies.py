"""Replies as the boards send them, with one field that says something else; checksums are right.

Frames are taken apart as the motors of the suite do, without the drivers' functions.
"""

from __future__ import annotations

import binascii
import struct
from collections.abc import Callable

from tests.support.hil.motors.cobs import Cobs
from tests.support.hil.motors.slcan import Lines, line

Spoil = Callable[[bytes], bytes]
COBS_REPLY = ("kind", "status", "sequence", "time", "first", "second", "spare")
ENABLED, FIRED, ZERO, FAULT, INPUT = 1, 2, 4, 8, 16


def haply(place: int, *data: float | int) -> Spoil:
    """A byte, or an angle (degrees), at a place of the nine bytes."""

    def spoil(answer: bytes) -> bytes:
        if len(answer) != 9:
            return answer
        new = struct.pack("<f" if isinstance(data[0], float) else "B", data[0])
        return answer[:place] + new + answer[place + len(new) :]

    return spoil


def framed(change: Callable[[bytes], bytes | None]) -> Spoil:
    """The payload of a frame of ours, before its checksum; ``None`` loses it."""

    def spoil(answer: bytes) -> bytes:
        body = change(Cobs.unstuffed(answer[:-1])[:-2])
        if body is None:
            return b""
        return Cobs.stuffed(body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big")) + b"\0"

    return spoil


def cobs(**wanted: int | Callable[[int], int]) -> Spoil:
    """Fields of a framed board's reply, each by its new value or by what is made of the old."""

    def change(body: bytes) -> bytes:
        values = dict(zip(COBS_REPLY, struct.unpack("<BBHIiiH", body), strict=True))
        for field, new in wanted.items():
            values[field] = new(values[field]) if callable(new) else new
        return struct.pack("<BBHIiiH", *values.values())

    return framed(change)


def frozen(field: str) -> Spoil:
    """A framed board's field that stays what it is."""
    first: list[int] = []

    def hold(old: int) -> int:
        first.append(old)
        return first[0]

    return cobs(**{field: hold})


def can(identifier: int, change: Callable[[bytes], bytes], *, mask: int = 0x7FF) -> Spoil:
    """The data of the frames with an identifier."""

    def spoil(answer: bytes) -> bytes:
        frames = Lines().frames(answer)
        return b"".join(
            line(name, change(data) if name & mask == identifier else data) for name, data in frames
        )

    return spoil


def besides(identifier: int, data: bytes) -> Spoil:
    """One more frame with every answer."""
    return lambda answer: answer + line(identifier, data)


def without(identifier: int) -> Spoil:
    """No frame with an identifier."""

    def spoil(answer: bytes) -> bytes:
        frames = Lines().frames(answer)
        return b"".join(line(name, data) for name, data in frames if name != identifier)

    return spoil


def packed(layout: str, place: int, value: float) -> Callable[[bytes], bytes]:
    """Data in which a number at a place is another one."""

    def change(data: bytes) -> bytes:
        new = struct.pack(layout, value)
        return data[:place] + new + data[place + len(new) :]

    return change
