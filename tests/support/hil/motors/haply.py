"""Haply's hAPI: no sync word, no length, no checksum, no watchdog."""

from __future__ import annotations

import struct

from tests.support.hil.motors.told import Told


class Haply:
    """Any motors and encoders that a setup names; each stands where the setup presets it."""

    def __init__(self, unknown: int = 1) -> None:
        """``unknown``: bytes that are dropped where a frame begins with none of the types."""
        self.unknown = unknown
        self.pending = b""
        self.motors = 0
        self.presets: list[float] = []

    def feed(self, data: bytes) -> list[Told]:
        self.pending += data
        found = []
        while len(self.pending) >= 2:
            kind, size = self.pending[0], 2
            if kind == 1:
                size = self.setup_size()
            elif kind == 2:
                size = 2 + 4 * self.motors
            elif kind != 0:
                size = self.unknown
            if size is None or len(self.pending) < size:
                break
            frame, self.pending = self.pending[:size], self.pending[size:]
            if kind == 1:
                self.set_up(frame)
            elif kind == 2:
                torques = struct.unpack(f"<{self.motors}f", frame[2:])
                answer = frame[1:2] + struct.pack(f"<{len(self.presets)}f", *self.presets)
                found.append(Told(torques, answer, zero=not any(torques)))
        return found

    def tick(self) -> list[Told]:
        return []

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
        values = struct.unpack(f"<{2 * encoders}f", frame[len(frame) - 8 * encoders :])
        self.presets = list(values[::2])
