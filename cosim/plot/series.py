"""Signals of runs, as they were recorded or held on the rows of others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, lcm

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.base.wildcard import compile_wildcard, is_wild
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal

MOST = 32
"""Traces in a figure; more is no picture."""

Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Span:
    """The part of a run that is looked at, in the model's time (s); ``until`` ``None``: its end."""

    start: Fraction = Fraction(0)
    until: Fraction | None = None


@dataclass(frozen=True, slots=True)
class TimeSeries:
    """One signal of one run.

    Attributes:
        run: where it was recorded.
        signal: what was recorded.
        run_name: how the figure names the run; empty where there is one alone.
    """

    run: Run
    signal: RecordedSignal
    run_name: str = ""

    @property
    def name(self) -> str:
        """The signal's."""
        return self.signal.name

    @property
    def label(self) -> str:
        """How a figure names it: with the run's name where there are several."""
        return f"{self.run_name}: {self.name}" if self.run_name else self.name

    @property
    def unit(self) -> str:
        """Its FMI unit; 1 where it has none."""
        return self.signal.unit or "1"

    @property
    def period(self) -> Fraction:
        """Seconds from row to row."""
        return self.signal.group.period / self.run.base_rate

    @property
    def start(self) -> Fraction:
        """The model's time at its first row (s)."""
        return self.run.start_tick / self.run.base_rate

    def rows(self, span: Span) -> tuple[int, int]:
        """First row and the one behind the last, of those that begin in the span."""
        total = self.signal.group.rows
        first = min(total, max(0, ceil((span.start - self.start) / self.period)))
        if span.until is None:
            return first, total
        return first, max(first, min(total, floor((span.until - self.start) / self.period) + 1))

    def times(self, first: int, last: int) -> Numbers:
        """The model's time at rows (s), each rounded once."""
        return self.run.seconds(np.arange(first, last, dtype=np.int64) * self.signal.group.period)

    def values(self, span: Span) -> tuple[Numbers, Numbers]:
        """Times (s) and values of the span's rows, each of shape (rows,).

        Raises:
            InputError: there is no row in the span.
        """
        first, last = self.rows(span)
        if first == last:
            raise InputError(
                f"{self.run.folder}: {self.signal.name} has no row from {float(span.start):g} s"
                + (f" to {float(span.until):g} s." if span.until is not None else " on.")
            )
        return self.times(first, last), self.signal[first:last].astype(np.float64)


def select(runs: Sequence[Run], patterns: Sequence[str]) -> list[TimeSeries]:
    """The signals that the patterns name, in each run, in the order of the patterns.

    A pattern is a name, or has ``*`` and ``?`` in it (``cosim.base.wildcard``); the name of a group
    or an array stands for all of it.

    Raises:
        InputError: one of them matches nothing in a run, or together they match too much.
    """
    names = labels(runs)
    found: list[TimeSeries] = []
    for pattern in patterns:
        for run, name in zip(runs, names, strict=True):
            shown = name if len(runs) > 1 else ""
            found += [TimeSeries(run, signal, shown) for signal in _matching(run, pattern)]
    chosen = list({(each.run.folder, each.signal.name): each for each in found}.values())
    if len(chosen) > MOST:
        raise InputError(
            f"{' '.join(patterns)} match {len(chosen)} signals, and a figure holds at most {MOST}: "
            "name fewer."
        )
    return chosen


def labels(runs: Sequence[Run]) -> list[str]:
    """A short name for each run: of its folder, with as many parents as tell them apart."""
    parts = [run.folder.absolute().parts for run in runs]
    for depth in range(1, max(map(len, parts)) + 1):
        short = ["/".join(each[-depth:]) for each in parts]
        if len({*short}) == len(short):
            return short
    return [str(run.folder) for run in runs]


def held_together(
    first: TimeSeries, second: TimeSeries, span: Span
) -> tuple[Numbers, Numbers, Numbers]:
    """Times (s) and the values of both on the rows of the faster, the slower one held.

    Shapes (rows,); from the later of their first rows to the earlier of their last.
    """
    fast, slow = sorted((first, second), key=lambda each: each.period)
    begin, end = fast.rows(span)
    # Whole numbers compare exactly where times in seconds would round.
    ratio, ahead = fast.period / slow.period, (fast.start - slow.start) / slow.period
    parts = lcm(ratio.denominator, ahead.denominator)
    rows = np.arange(begin, end, dtype=np.int64) * int(ratio * parts) + int(ahead * parts)
    rows //= parts
    inside = (rows >= 0) & (rows < slow.signal.group.rows)
    time = fast.times(begin, end)[inside]
    if not time.size:
        raise InputError(f"{first.label} and {second.label} have no moment in common in this span.")
    rows = rows[inside]
    low = int(rows[0])
    known = slow.signal[low : int(rows[-1]) + 1].astype(np.float64)
    of = {
        fast: fast.signal[begin:end].astype(np.float64)[inside],
        slow: known[rows - low],
    }
    return time, of[first], of[second]


def reduced(time: Numbers, values: Numbers, points: int) -> tuple[Numbers, Numbers]:
    """At most ``points`` of the rows: of each bin the least and the greatest, where they stand.

    A line through them covers the same pixels, so that no spike of one tick is lost.
    """
    if time.size <= points:
        return time, values
    kept = _extremes([values], points)
    return time[kept], values[kept]


def reduced_way(x: Numbers, y: Numbers, points: int) -> tuple[Numbers, Numbers]:
    """The same of a way through a plane: of each bin the least and the greatest of either."""
    if x.size <= points:
        return x, y
    kept = _extremes([x, y], points)
    return x[kept], y[kept]


def _extremes(columns: Sequence[Numbers], points: int) -> NDArray[np.intp]:
    """Rows, in order: the first, the last, and of each bin those that are extreme in a column."""
    rows = columns[0].size
    size = -(-2 * len(columns) * rows // max(1, points - 2))
    bins = -(-rows // size)
    offset = np.arange(bins) * size
    kept: list[NDArray[np.intp]] = [np.array([0, rows - 1])]
    for column in columns:
        known = np.where(np.isnan(column), 0.0, column)
        cut = np.pad(known, (0, bins * size - rows), "edge").reshape(bins, size)
        kept += [cut.argmin(1) + offset, cut.argmax(1) + offset]
    return np.unique(np.minimum(np.concatenate(kept), rows - 1))


def _matching(run: Run, pattern: str) -> list[RecordedSignal]:
    if pattern in run.signals:
        return [run.signals[pattern]]
    expression = compile_wildcard(pattern)
    found = [signal for name, signal in run.signals.items() if expression.fullmatch(name)]
    if not found:
        hint = "" if is_wild(pattern) else did_you_mean(pattern, run.signals)
        raise InputError(f"{run.folder}: nothing recorded in it matches '{pattern}'.{hint}")
    return found
