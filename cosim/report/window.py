"""Measures of one target over a window of time: extremes, moments, counts, amplitude.

To have a new measure, add a function of a :class:`Window` to ``MEASURES``; every comparison of
``cosim.report.expectation`` then works with it. No measure has to think of rows without a number or
of too few rows: :class:`Measure` asks before it does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

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
        self._half_rows = [0, 0]
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
    def is_finite(self) -> bool:
        """Whether every row holds a finite number."""
        ends = math.isfinite(self.minimum) and math.isfinite(self.maximum)
        return ends and self.rows == self._moment()[0]

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
        the time from the middle of the one to that of the other; 0 where nothing moves, and NaN
        where a half has less than two rows: one value moves nowhere.
        """
        self._count("halves")
        if min(self._half_rows) < 2:
            return math.nan
        widths = [max(high - low, _NARROW) for low, high in self._halves]
        between = (self._span[1] - self._span[0]) / 2
        return math.log(widths[1] / widths[0]) / between if between > 0 else math.nan

    @property
    def amplitude(self) -> float:
        """Amplitude of the least-squares fit of c + a·cos(ωt) + b·sin(ωt).

        NaN without ω, and where the rows cannot tell it from a constant or from a slower sine.
        """
        if self.frequency is None or self.untold:
            return math.nan
        _, cosine, sine = np.linalg.lstsq(self._normal, self._right, rcond=None)[0]
        return float(np.hypot(cosine, sine))

    @property
    def untold(self) -> str:
        """Why these rows tell no sine of this frequency, if they do not."""
        lasting = self._span[1] - self._span[0]
        step = lasting / max(self.rows - 1, 1)
        return "" if self.frequency is None else can_not_tell(self.frequency, lasting, step)

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
                self._half_rows[0] += edge
                self._half_rows[1] += values.size - edge
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


def can_not_tell(frequency: float, lasting: float, step: float) -> str:
    """Why rows ``step`` apart (s) that last so long (s) tell no sine of a frequency (rad/s)."""
    period = 2 * math.pi / frequency
    if lasting + step < period:
        return f"{lasting + step:.4g} s are less than one period, which lasts {period:.4g} s"
    if 2 * step >= period:
        return f"one sample every {step:.4g} s is too few for a period of {period:.4g} s"
    return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """A number about a window, and what it takes to tell it."""

    function: Callable[[Window], float]
    unit: str | None = None
    """Its own unit; ``None`` for that of what is measured."""
    samples: int = 1
    """How many rows it takes."""
    least: float | None = None
    """The least that it can be; ``None`` where it is one of the values."""

    def __call__(self, window: Window) -> float:
        """The number; NaN where the window has too few rows, or one without a finite number."""
        is_told = window.rows >= self.samples and window.is_finite
        return self.function(window) if is_told else math.nan


def _of(function: Callable[[Window], float]) -> Measure:
    return Measure(function=function)


MEASURES: dict[str, Measure] = {
    "min": _of(lambda window: window.minimum),
    "max": _of(lambda window: window.maximum),
    "max_abs": Measure(
        function=lambda window: max(abs(window.minimum), abs(window.maximum)), least=0.0
    ),
    "peak_to_peak": Measure(
        function=lambda window: window.maximum - window.minimum, samples=2, least=0.0
    ),
    "mean": _of(lambda window: window.mean),
    "rms": Measure(function=lambda window: window.rms, least=0.0),
    "std": Measure(function=lambda window: window.std, samples=2, least=0.0),
    "initial": _of(lambda window: window.first),
    "final": _of(lambda window: window.last),
    "change": Measure(
        function=lambda window: window.last - window.first, samples=2, least=-math.inf
    ),
    "amplitude": Measure(function=lambda window: window.amplitude, samples=3, least=0.0),
    "change_count": Measure(function=lambda window: window.changes, unit="", samples=2, least=0.0),
    "loss_count": Measure(function=lambda window: window.losses, unit="", samples=2, least=0.0),
    "growth": Measure(
        function=lambda window: window.growth, unit="1/s", samples=4, least=-math.inf
    ),
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
