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
from cosim.record.statistics import Moments
from cosim.report.target import Target, blocks

_NARROW = 1e-300
"""In place of no width at all, so that its logarithm is a number."""
_ACCUMULATED = ("losses", "extremes", "halves", "moments", "changes")
_NOTHING = np.zeros(0)
_NO_WIDTHS = (math.inf, -math.inf), (math.inf, -math.inf)
_NO_FIT = np.zeros((3, 3)), np.zeros(3)


class Window:
    """One target over a window of time, taken piece by piece.

    What nobody asks for is not computed while all rows are one piece.
    """

    def __init__(self, frequency: float | None = None, middle: float = math.inf) -> None:
        """Begin with nothing.

        ``frequency`` (rad/s) is that of the sine whose amplitude is asked for, ``middle`` (s) the
        time that parts the two halves whose growth is.
        """
        self.frequency = frequency
        self.rows = 0
        """Rows taken so far."""
        self.first = self.last = math.nan
        self._middle = middle
        self._span = 0.0, 0.0
        self._times = self._piece = _NOTHING
        """The last rows taken."""
        self._due: set[str] = set()
        """What has not counted them yet."""
        self._losses = self._changes = 0
        self._extremes = math.nan, math.nan
        self._halves: tuple[tuple[float, float], ...] = _NO_WIDTHS
        self._moments: Moments | None = None
        self._before: NDArray[np.int64] | None = None
        """The row before the last ones, bit for bit."""
        self._normal, self._right = _NO_FIT

    def update(self, time: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Take the next rows: time (s) and values, both of shape (rows,)."""
        if not values.size:
            return
        if self.rows == 0:
            self.first = self.last = float(values[0])
            self._span = float(time[0]), float(time[0])
        else:
            for what in _ACCUMULATED:
                self._count(what)
            self._before = self._piece[-1:].view(np.int64)
        self._losses += int(self.last != 0 and values[0] == 0)
        self.last = float(values[-1])
        self.rows += values.size
        self._piece, self._times = values, time
        self._due = set(_ACCUMULATED)
        self._span = self._span[0], float(time[-1])
        if self.frequency is not None:
            angle = self.frequency * time
            basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
            self._normal = self._normal + basis @ basis.T
            self._right = self._right + basis @ values

    @property
    def losses(self) -> int:
        """How often the value fell from anything to zero."""
        self._count("losses")
        return self._losses

    @property
    def minimum(self) -> float:
        """The least value; NaN where there is none."""
        self._count("extremes")
        return self._extremes[0]

    @property
    def maximum(self) -> float:
        """The greatest value; NaN where there is none."""
        self._count("extremes")
        return self._extremes[1]

    @property
    def missing(self) -> int:
        """Rows that hold no number."""
        return self.rows - self._moment()[0]

    @property
    def mean(self) -> float:
        """Over the rows that hold a number."""
        return self._moment()[1]

    @property
    def rms(self) -> float:
        """The root of the mean of squares."""
        return self._moment()[2]

    @property
    def std(self) -> float:
        """The rms deviation from the mean."""
        return self._moment()[3]

    @property
    def changes(self) -> int:
        """How many rows differ, bit for bit, from the row before."""
        self._count("changes")
        return self._changes

    @property
    def growth(self) -> float:
        """How fast what moves grows (1/s), or dies away: less than 0.

        The logarithm of how much wider the values lie in the second half than in the first, over
        the time from the middle of the one to that of the other; 0 where nothing moves.
        """
        self._count("halves")
        widths = [max(high - low, _NARROW) for low, high in self._halves]
        between = (self._span[1] - self._span[0]) / 2
        return math.log(widths[1] / widths[0]) / between if between > 0 else math.nan

    @property
    def amplitude(self) -> float:
        """Amplitude of the least-squares fit of c + a·cos(ωt) + b·sin(ωt); NaN without ω."""
        if self.frequency is None:
            return math.nan
        _, cosine, sine = np.linalg.lstsq(self._normal, self._right, rcond=None)[0]
        return float(np.hypot(cosine, sine))

    def _moment(self) -> tuple[int, float, float, float]:
        self._count("moments")
        return (0, math.nan, math.nan, math.nan) if self._moments is None else self._moments.of(0)

    def _count(self, what: str) -> None:
        """Take the last rows into one of the accumulated, once."""
        if what not in self._due:
            return
        self._due.discard(what)
        values = self._piece
        match what:
            case "losses":
                self._losses += int(np.count_nonzero((values[:-1] != 0) & (values[1:] == 0)))
            case "extremes":
                low, high = self._extremes
                self._extremes = (
                    float(np.fmin.reduce(values, initial=low)),
                    float(np.fmax.reduce(values, initial=high)),
                )
            case "halves":
                edge = int(np.searchsorted(self._times, self._middle))
                pairs = zip(self._halves, (values[:edge], values[edge:]), strict=True)
                self._halves = tuple(
                    (
                        float(np.fmin.reduce(part, initial=low)),
                        float(np.fmax.reduce(part, initial=high)),
                    )
                    for (low, high), part in pairs
                )
            case "moments":
                self._moments = self._moments or Moments(1)
                self._moments.update(values[None])
            case _:
                cells = np.ascontiguousarray(values).view(np.int64)
                self._changes += int(np.count_nonzero(cells[1:] != cells[:-1]))
                if self._before is not None:
                    self._changes += int(self._before[0] != cells[0])


MEASURES: dict[str, Callable[[Window], float]] = {
    "min": lambda window: window.minimum,
    "max": lambda window: window.maximum,
    "max_abs": lambda window: max(abs(window.minimum), abs(window.maximum)),
    "peak_to_peak": lambda window: window.maximum - window.minimum,
    "mean": lambda window: window.mean,
    "rms": lambda window: window.rms,
    "std": lambda window: window.std,
    "initial": lambda window: window.first,
    "final": lambda window: window.last,
    "change": lambda window: window.last - window.first,
    "amplitude": lambda window: window.amplitude,
    "change_count": lambda window: window.changes,
    "loss_count": lambda window: window.losses,
    "growth": lambda window: window.growth,
}


def measure(
    run: Run, target: Target, first: int, last: int, frequency: float | None = None
) -> Window:
    """Take a target over ticks ``first`` <= tick < ``last``, piece by piece."""
    last = min(last, run.ticks)
    middle = run.start_tick + (first + last) / 2
    window = Window(frequency, middle=middle / float(run.base_rate))
    for ticks, values in blocks(run, target, first, last):
        window.update(run.seconds(ticks), values.astype(np.float64, copy=False))
    return window
