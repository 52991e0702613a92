"""How late the ticks of a loop began, and what made them late: counted, never stored one by one."""

from __future__ import annotations

from array import array
from enum import StrEnum
from typing import Any

BINS = 20_000
"""Bins of one microsecond; what is later falls into the last one."""


class MissCause(StrEnum):
    """What made a tick begin a whole period or more late."""

    WAKE_UP = "woken late"
    """The loop slept, and the system woke it late."""
    INTERRUPTED = "interrupted"
    """The tick before took long, but the processor worked on something else meanwhile."""
    WORK = "own work"
    """The tick before took long by itself."""


class Deadlines:
    """A histogram of lateness (1 us bins), the worst, and the misses with their causes."""

    def __init__(self) -> None:
        self._bins = array("q", bytes(8 * (BINS + 1)))
        self.ticks = 0
        self.misses = 0
        """Ticks that began a whole period or more after the moment they were meant for."""
        self.slipped = 0
        """Periods by which the grid of deadlines has moved."""
        self.caught_up = 0
        """Ticks that came early after their predecessor, to get back to the grid."""
        self.off_grid = 0
        """Ticks that began a whole period or more after their place on the grid, the ticks in
        which a miss was being caught up included."""
        self.worst = 0
        """Longest time from the moment a tick was meant for to its beginning (ns)."""
        self.farthest = 0
        """Farthest that a tick began after its place on the grid (ns)."""
        self.causes = dict.fromkeys(MissCause, 0)
        """Misses by cause."""
        self.lost = dict.fromkeys(MissCause, 0)
        """Time (ns) that the misses of each cause were late."""
        self.longest: dict[str, int] = {}
        """Misses by own work, by the part of the tick that took longest."""

    def add(self, late: int) -> None:
        """One tick began ``late`` ns after its deadline."""
        self.ticks += 1
        micro = late // 1000
        self._bins[micro if 0 <= micro < BINS else (BINS if micro > 0 else 0)] += 1
        self.worst = max(self.worst, late)

    def miss(self, late: int, cause: MissCause, part: str | None = None) -> None:
        """One tick began a period or more late; ``part`` is what its own work was longest in."""
        self.misses += 1
        self.causes[cause] += 1
        self.lost[cause] += late
        if part is not None:
            self.longest[part] = self.longest.get(part, 0) + 1

    def percentile(self, share: float) -> float:
        """Lateness (s) that ``share`` of the ticks (0 to 1) did not exceed, to 1 us."""
        wanted, seen = share * self.ticks, 0
        for micro, count in enumerate(self._bins):
            seen += count
            if count and seen >= wanted:
                return (micro + 1) * 1e-6 if micro < BINS else self.worst * 1e-9
        return 0.0

    def histogram(self) -> list[tuple[float, int]]:
        """(upper edge in s, ticks) in octaves from 1 us, for reports."""
        edges: list[tuple[float, int]] = []
        low, high = 0, 1
        while low <= BINS:
            count = sum(self._bins[low : min(high, BINS + 1)])
            edges.append((high * 1e-6, count))
            low, high = high, high * 2
        return edges

    def summary(self) -> dict[str, Any]:
        """What goes into a run's manifest; times in s."""
        return {
            "ticks": self.ticks,
            "misses": self.misses,
            "slipped_periods": self.slipped,
            "caught_up": self.caught_up,
            "off_grid": self.off_grid,
            "worst": self.worst * 1e-9,
            "farthest_behind": self.farthest * 1e-9,
            "p50": self.percentile(0.5),
            "p99": self.percentile(0.99),
            "p99.9": self.percentile(0.999),
            "causes": {
                str(cause): {"misses": count, "seconds": self.lost[cause] * 1e-9}
                for cause, count in self.causes.items()
            },
            "longest_part": dict(self.longest),
            "histogram": self.histogram(),
        }
