"""Measures of one target over a window of time: extremes, moments, counts, amplitude.

To have a new measure, add a function of a :class:`Window` to ``MEASURES``; every comparison of
``cosim.report.expectation`` then works with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cosim.record.reader import Run
from cosim.record.statistics import ColumnStatistics, Statistics
from cosim.report.target import Target, blocks

ANY_LENGTH = 1 << 62
"""More rows than any window has: one pair of extremes for all of them."""

_NARROW = 1e-300
"""In place of no width at all, so that its logarithm is a number."""


class Window:
    """One target over a window of time, taken piece by piece."""

    def __init__(self, frequency: float | None = None, middle: float = math.inf) -> None:
        """Begin with nothing.

        ``frequency`` (rad/s) is that of the sine whose amplitude is asked for, ``middle`` (s) the
        time that parts the two halves whose growth is.
        """
        self.frequency = frequency
        self._middle = middle
        self._halves = [[math.inf, -math.inf], [math.inf, -math.inf]]
        self._times: NDArray[np.float64] = np.zeros(0)
        self._span = [0.0, 0.0]
        self.first = math.nan
        self.last = math.nan
        self._losses = 0
        self._statistics: ColumnStatistics | None = None
        self._waiting: NDArray[np.float64] | None = None
        """The last rows taken: where they are all there are, an extreme needs no statistics."""
        self._uncounted: NDArray[np.float64] | None = None
        """The last rows taken, as long as nobody has asked for the losses in them."""
        self._unmeasured: NDArray[np.float64] | None = None
        """The same for how far the values lie apart in each half."""
        self._normal = np.zeros((3, 3))
        self._right = np.zeros(3)

    def update(self, time: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Take the next rows: time (s) and values, both of shape (rows,)."""
        if not values.size:
            return
        if self.rows == 0:
            self.first = self.last = float(values[0])
            self._span = [float(time[0]), float(time[0])]
        if self._waiting is not None:
            self._losses = self.losses
            self._widen()
            self._merge(self._waiting)
        self._losses += int(self.last != 0 and values[0] == 0)
        self.last = float(values[-1])
        self._waiting, self._times = values, time
        self._uncounted = self._unmeasured = values
        self._span[1] = float(time[-1])
        if self.frequency is not None:
            angle = self.frequency * time
            basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
            self._normal += basis @ basis.T
            self._right += basis @ values

    @property
    def rows(self) -> int:
        """Rows taken so far."""
        waiting = 0 if self._waiting is None else self._waiting.size
        return waiting + (0 if self._statistics is None else self._statistics.rows)

    @property
    def losses(self) -> int:
        """How often the value fell from anything to zero."""
        if (values := self._uncounted) is not None:
            self._losses += int(np.count_nonzero((values[:-1] != 0) & (values[1:] == 0)))
            self._uncounted = None
        return self._losses

    @property
    def minimum(self) -> float:
        """The least value; NaN where there is none."""
        if self._statistics is None and self._waiting is not None:
            return float(np.fmin.reduce(self._waiting))
        return self.statistics.minimum

    @property
    def maximum(self) -> float:
        """The greatest value; NaN where there is none."""
        if self._statistics is None and self._waiting is not None:
            return float(np.fmax.reduce(self._waiting))
        return self.statistics.maximum

    @property
    def statistics(self) -> Statistics:
        """Extremes, mean and the like."""
        if self._waiting is not None:
            self._merge(self._waiting)
            self._waiting = None
        return self._kept[0]

    @property
    def _kept(self) -> ColumnStatistics:
        if self._statistics is None:
            self._statistics = ColumnStatistics(np.array([True]), ANY_LENGTH, bins=1)
        return self._statistics

    @property
    def growth(self) -> float:
        """How fast what moves grows (1/s), or dies away: less than 0.

        The logarithm of how much wider the values lie in the second half than in the first, over
        the time from the middle of the one to that of the other; 0 where nothing moves.
        """
        self._widen()
        widths = [max(high - low, _NARROW) for low, high in self._halves]
        between = (self._span[1] - self._span[0]) / 2
        return math.log(widths[1] / widths[0]) / between if between > 0 else math.nan

    def _merge(self, values: NDArray[np.float64]) -> None:
        self._kept.update(np.ascontiguousarray(values).view(np.int64)[None])

    def _widen(self) -> None:
        """Take the last rows into the extremes of the halves, once."""
        values, self._unmeasured = self._unmeasured, None
        if values is None:
            return
        edge = int(np.searchsorted(self._times, self._middle))
        for half, part in zip(self._halves, (values[:edge], values[edge:]), strict=True):
            half[0] = float(np.fmin.reduce(part, initial=half[0]))
            half[1] = float(np.fmax.reduce(part, initial=half[1]))

    @property
    def amplitude(self) -> float:
        """Amplitude of the least-squares fit of c + a·cos(ωt) + b·sin(ωt); NaN without ω."""
        if self.frequency is None:
            return math.nan
        _, cosine, sine = np.linalg.lstsq(self._normal, self._right, rcond=None)[0]
        return float(np.hypot(cosine, sine))


MEASURES: dict[str, Callable[[Window], float]] = {
    "min": lambda window: window.minimum,
    "max": lambda window: window.maximum,
    "max_abs": lambda window: max(abs(window.minimum), abs(window.maximum)),
    "peak_to_peak": lambda window: window.maximum - window.minimum,
    "mean": lambda window: window.statistics.mean,
    "rms": lambda window: window.statistics.rms,
    "std": lambda window: window.statistics.std,
    "initial": lambda window: window.first,
    "final": lambda window: window.last,
    "change": lambda window: window.last - window.first,
    "amplitude": lambda window: window.amplitude,
    "change_count": lambda window: window.statistics.changes,
    "loss_count": lambda window: window.losses,
    "growth": lambda window: window.growth,
}


def measure(
    run: Run, target: Target, first: int, last: int, frequency: float | None = None
) -> Window:
    """Take a target over ticks ``first`` <= tick < ``last``, piece by piece."""
    window = Window(frequency, middle=float((first + last) / 2 / run.base_rate))
    for ticks, values in blocks(run, target, first, last):
        window.update(run.seconds(ticks), values.astype(np.float64, copy=False))
    return window
