"""The times of a record: base ticks in seconds."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray


class RecordTimes:
    """Of one record."""

    def __init__(self, base_rate: Fraction, start_tick: int) -> None:
        self.base_rate = base_rate
        """Base ticks a second (Hz)."""
        self.start_tick = start_tick
        """How many base ticks after time 0 the first one is."""
        self._timed: tuple[NDArray[np.int64] | None, NDArray[np.float64]] = None, np.zeros(0)

    def seconds(self, ticks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Times (s) of base ticks: one division by the base rate, so rounded once."""
        if ticks is self._timed[0]:
            return self._timed[1]
        rate = self.base_rate
        since_0 = (ticks + self.start_tick) * rate.denominator
        seconds = np.divide(since_0, rate.numerator, dtype=np.float64)
        if not ticks.flags.writeable:  # they stay what they are
            self._timed = ticks, seconds
        return seconds
