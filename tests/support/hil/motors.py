"""Motors at the other end of a wire: they read bytes as a board would, and note what they are told.

Written from the protocols' descriptions alone, apart from the product's drivers and emulators, and
run as a process of its own: ``python motors.py haply``. It prints the port to open; ``now`` on its
standard input makes it print its torques, ``dump`` every torque with its time (CLOCK_MONOTONIC),
and how long it was away from its work itself: the probe beside what it measures. No watchdog drops
the torque here.
"""

from __future__ import annotations

import binascii
import contextlib
import json
import os
import select
import struct
import sys
import time
import tty

TICK = 1 / 1024


class Haply:
    """Any motors and encoders that a setup names; each stands where the setup presets it."""

    def __init__(self) -> None:
        self.pending = b""
        self.motors = 0
        self.presets: list[float] = []

    def feed(self, data: bytes) -> list[tuple[tuple[float, ...], bytes]]:
        """(torques, answer) of every command that is complete."""
        self.pending += data
        found = []
        while len(self.pending) >= 2:
            kind, size = self.pending[0], 2
            if kind == 1:
                size = self.setup_size()
            elif kind == 2:
                size = 2 + 4 * self.motors
            elif kind != 0:
                size = 1
            if size is None or len(self.pending) < size:
                break
            frame, self.pending = self.pending[:size], self.pending[size:]
            if kind == 1:
                self.set_up(frame)
            elif kind == 2:
                torques = struct.unpack(f"<{self.motors}f", frame[2:])
                answer = frame[1:2] + struct.pack(f"<{len(self.presets)}f", *self.presets)
                found.append((torques, answer))
        return found

    def setup_size(self) -> int | None:
        """01 dev | motor mask, dir x n | encoder mask, dir x n | n, pins | n, pins | (f, f) x n."""
        place, counts = 2, []
        for _ in range(2):
            if len(self.pending) <= place:
                return None
            counts.append(self.pending[place].bit_count())
            place += 1 + counts[-1]
        for _ in range(2):
            if len(self.pending) <= place:
                return None
            place += 1 + self.pending[place]
        return place + 8 * counts[1]

    def set_up(self, frame: bytes) -> None:
        self.motors = frame[2].bit_count()
        encoders = frame[3 + self.motors].bit_count()
        values = struct.unpack(f"<{2 * encoders}f", frame[-8 * encoders :])
        self.presets = list(values[::2])


class Cobs:
    """Two motors behind the framed protocol; both encoders stand at zero counts."""

    def __init__(self) -> None:
        self.pending = b""

    def feed(self, data: bytes) -> list[tuple[tuple[float, ...], bytes]]:
        """(torques, answer) of every valid command."""
        *frames, self.pending = (self.pending + data).split(b"\0")
        found = []
        for frame in frames:
            body = self.unstuffed(frame)
            if len(body) != 16 or body[0] != 1:
                continue
            if binascii.crc_hqx(body[:14], 0xFFFF) != int.from_bytes(body[14:], "big"):
                continue
            _, flags, sequence, first, second, _ = struct.unpack("<BBHffH", body[:14])
            torque = (first, second) if flags & 1 else (0.0, 0.0)
            status = (flags & 1) | (4 if torque == (0.0, 0.0) else 0)
            now = round(time.monotonic() * 1e6) & 0xFFFFFFFF
            reply = struct.pack("<BBHIiiH", 0x81, status, sequence, now, 0, 0, 0)
            reply += binascii.crc_hqx(reply, 0xFFFF).to_bytes(2, "big")
            found.append((torque, self.stuffed(reply) + b"\0"))
        return found

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


def main() -> None:
    """Answer until standard input is closed."""
    motors = {"haply": Haply, "cobs": Cobs}[sys.argv[1]]()
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    print(os.ttyname(slave), flush=True)
    seen: list[tuple[float, ...]] = []
    away: list[tuple[float, float]] = []
    last = time.monotonic()
    while True:
        ready, _, _ = select.select([master, 0], [], [], TICK)
        now = time.monotonic()
        if now - last > 4 * TICK:
            away.append((now, now - last))
        last = now
        if master in ready:
            for torques, answer in motors.feed(os.read(master, 65536)):
                seen.append((now, *torques))
                with contextlib.suppress(BlockingIOError):
                    os.write(master, answer)
        if 0 in ready:
            word = os.read(0, 100)
            if not word:
                return
            # A long answer would keep the motors from looking: it is for the end.
            now = seen[-1][1:] if seen else (0.0, 0.0)
            print(
                json.dumps({"seen": seen, "away": away} if word == b"dump\n" else now), flush=True
            )


if __name__ == "__main__":
    main()
