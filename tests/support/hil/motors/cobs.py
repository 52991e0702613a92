"""Two motors behind the framed protocol of home-made boards."""

from __future__ import annotations

import binascii
import struct
import time

from tests.support.hil.motors.told import Told


class Cobs:
    """Both encoders stand at zero counts."""

    def __init__(self) -> None:
        self.pending = b""
        self.fired = self.enabled = False
        self.silence, self.limit = 0, 0
        self.began = time.monotonic()

    def feed(self, data: bytes) -> list[Told]:
        *frames, self.pending = (self.pending + data).split(b"\0")
        found = []
        for frame in frames:
            body = self.unstuffed(frame)
            if len(body) != 16 or body[0] != 1:
                continue
            if binascii.crc_hqx(body[:14], 0xFFFF) != int.from_bytes(body[14:], "big"):
                continue
            _, flags, sequence, first, second, self.limit = struct.unpack("<BBHffH", body[:14])
            self.silence = 0
            self.fired &= not flags & 2
            self.enabled = bool(flags & 1) and not self.fired
            torque = (first, second) if flags & 1 else (0.0, 0.0)
            zero = not any(torque)
            now = round((time.monotonic() - self.began) * 1e6) & 0xFFFFFFFF
            status = self.enabled | self.fired << 1 | (4 if zero else 0)
            reply = struct.pack("<BBHIiiH", 0x81, status, sequence, now, 0, 0, 0)
            reply += binascii.crc_hqx(reply, 0xFFFF).to_bytes(2, "big")
            found.append(Told(torque, self.stuffed(reply) + b"\0", zero))
        return found

    def tick(self) -> list[Told]:
        self.silence += 1
        if self.enabled and self.silence > self.limit:
            self.fired, self.enabled = True, False
        return []

    @staticmethod
    def unstuffed(frame: bytes) -> bytes:
        body, place = b"", 0
        while place < len(frame):
            length = frame[place]
            body += frame[place + 1 : place + length] + b"\0"
            place += length
        return body[:-1]

    @staticmethod
    def stuffed(body: bytes) -> bytes:
        return b"".join(bytes([len(part) + 1]) + part for part in body.split(b"\0"))
