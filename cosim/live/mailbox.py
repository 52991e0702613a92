"""Where a page's pointer is, in shared memory: the server writes, the loop looks once a tick."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from cosim.realtime.ring import Ring

FINGERS = 2
CELLS = 2 + 2 * FINGERS
"""Time of the sample (s, monotonic), whether somebody is there, and x, y of each finger (m)."""


class Mailbox:
    """The newest sample of one user's pointer; the count of samples numbers it."""

    def __init__(self, ring: Ring) -> None:
        self._ring = ring

    @classmethod
    def create(cls) -> Self:
        """A new one, empty.

        Raises:
            RunError: there is no room for it in shared memory.
        """
        return cls(Ring.create(CELLS, capacity=16, what="the pointer of a page"))

    @classmethod
    def attach(cls, path: Path) -> Self:
        """One that another process has made."""
        return cls(Ring(path))

    @property
    def path(self) -> Path:
        """Where others attach."""
        return self._ring.path

    @property
    def count(self) -> int:
        """Number of the newest sample, from 1; 0 where there is none."""
        return int(self._ring.head[1])

    def post(self, time: float, positions: list[float], *, present: bool) -> int:
        """Leave a sample, and return its number."""
        self._ring.write([time, float(present), *positions])
        return self.count

    def newest(self) -> list[float] | None:
        """Time, presence and positions of the newest sample."""
        found = self._ring.newest(tries=3)
        return None if found is None else found.tolist()

    def remove(self) -> None:
        """Nobody needs it any more."""
        self._ring.remove()
