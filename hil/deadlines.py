"""How late the ticks of a loop began: counted, never stored one by one."""

from __future__ import annotations

from array import array
from typing import Any

BINS = 20_000
"""Bins of one microsecond; what is later falls into the last one."""


class Deadlines:
    """A histogram of lateness (1 us bins), the worst, and the misses."""

    def __init__(self) -> None:
        self._bins = array("q", bytes(8 * (BINS + 1)))
        self.ticks = 0
        self.misses = 0
        """Ticks that began a whole period or more after their deadline."""
        self.slipped = 0
        """Periods by which the grid of deadlines has moved."""
        self.worst = 0
        """Longest time from a deadline to the beginning of its tick (ns)."""

    def add(self, late: int) -> None:
        """One tick began ``late`` ns after its deadline."""
        self.ticks += 1
        self._bins[min(max(late, 0) // 1000, BINS)] += 1
        self.worst = max(self.worst, late)

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
            "worst": self.worst * 1e-9,
            "p50": self.percentile(0.5),
            "p99": self.percentile(0.99),
            "p99.9": self.percentile(0.999),
            "histogram": self.histogram(),
        }
