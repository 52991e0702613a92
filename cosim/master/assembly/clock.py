"""Time as an integer tick: seconds are only ever computed from it, rounded once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from cosim.base.errors import InputError

HYPERPERIOD_LIMIT = 1 << 22
"""Longest pattern of due components that is compiled (ticks)."""

EXACT = 1 << 53
"""Whole numbers up to here are exact in a double."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The base rate (Hz), the time of the first tick, and what follows from them."""

    base_rate: Fraction
    start_tick: int = 0
    """How many ticks after time 0 the first one is."""

    @property
    def tick(self) -> Fraction:
        """One base tick (s)."""
        return 1 / self.base_rate

    def seconds(self, tick: int) -> float:
        """The time of a tick (s), rounded once."""
        return float((self.start_tick + tick) * self.tick)

    def step(self, period: int, substeps: int = 1) -> float:
        """The length of one of ``substeps`` equal steps over ``period`` ticks (s), rounded once."""
        return float(period * self.tick / substeps)

    def hyperperiod(self, periods: Iterable[int]) -> int:
        """After how many ticks the pattern of due components repeats.

        Raises:
            InputError: later than ``HYPERPERIOD_LIMIT``.
        """
        pattern = math.lcm(*periods)
        if pattern > HYPERPERIOD_LIMIT:
            raise InputError(
                f"the rates only fall together every {pattern} base ticks, more than the "
                f"{HYPERPERIOD_LIMIT} that are planned ahead; choose rates that divide each other"
            )
        return pattern

    def check_exact(self, ticks: int, substeps: int, component: str) -> None:
        """Refuse a run so long that a tick's time would be rounded twice.

        Raises:
            InputError: the time is no ratio of two integers that doubles hold exactly.
        """
        largest = (self.start_tick + ticks) * substeps * self.tick.numerator
        if max(largest, substeps * self.tick.denominator) >= EXACT:
            raise InputError(
                f"{ticks} base ticks with {substeps} sub-steps of {component} are too many to keep "
                "its time exact; shorten the run"
            )
