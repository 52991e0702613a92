"""Frames on a serial line of ours: COBS(payload + CRC-16) and a zero byte.

A reader is back in step at the next zero byte whatever was lost. CRC-16/CCITT-FALSE (polynomial
0x1021, initial 0xFFFF), high byte first, because only in that order does it notice every burst of
up to 16 bits that reaches into it. Source of COBS: S. Cheshire and M. Baker, IEEE/ACM Trans.
Networking 7(2), 1999.
"""

from __future__ import annotations

import binascii
import struct

CRC_BYTES = 2
LONGEST_FRAME = 64
"""More bytes than this without a zero byte are noise."""


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
