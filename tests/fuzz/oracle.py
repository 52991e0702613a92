"""COBS and CRC-16 once more, straight from their definitions; shares nothing with the product."""

from __future__ import annotations


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE, a bit at a time (ITU-T V.41 polynomial x^16 + x^12 + x^5 + 1)."""
    register = 0xFFFF
    for byte in data:
        for bit in range(7, -1, -1):
            carry = (register >> 15) ^ (byte >> bit & 1)
            register = (register << 1 ^ (0x1021 if carry else 0)) & 0xFFFF
    return register


def unstuffed(stuffed: bytes) -> bytes | None:
    """COBS undone a byte at a time (Cheshire and Baker 1999, without the 254-byte case)."""
    out, left = [], 0
    for place, byte in enumerate(stuffed):
        if left == 0:
            if place:
                out.append(0)
            if byte == 0:
                return None
            left = byte - 1
        else:
            out.append(byte)
            left -= 1
    return bytes(out) if stuffed and left == 0 else None


def payloads(stream: bytes) -> list[bytes]:
    """The payloads of a stream whose checksum is right, whatever they mean."""
    found = []
    for piece in stream.split(b"\0")[:-1]:
        plain = unstuffed(piece)
        if plain is not None and len(plain) > 2:
            body, check = plain[:-2], plain[-2] << 8 | plain[-1]
            if crc16(body) == check:
                found.append(body)
    return found
