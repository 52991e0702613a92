"""Signals that have run away: numbers, but no longer those of hands, boxes and motors.

An unstable loop gives finite values for a long time; they only grow. What a haptic bench can reach
is known, so a signal far beyond that is told, however the loop came to diverge. Decision 203 has
the bounds' reasons and what a run that ran away stands for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from cosim.record.reader import Run
from cosim.report.measures import Extremes

BOUNDS: Mapping[str, float] = {
    "m": 100.0,
    "m/s": 1e3,
    "N": 1e5,
    "N.m": 1e4,
    "rad": 1e5,
    "rad/s": 1e5,
    "W": 1e7,
    "J": 1e7,
}
"""Largest size of a signal by its unit, some hundred times what a bench can reach."""
OTHERWISE = 1e12
"""The same for every other floating-point signal."""


def bound_of(unit: str) -> float:
    """The largest size that a signal of a unit has on a bench."""
    return BOUNDS.get(unit, OTHERWISE)


@dataclass(frozen=True, slots=True)
class Runaway:
    """One signal that left its bound: since which tick and when (s), and how far it came."""

    signal: str
    unit: str
    bound: float
    tick: int
    since: float
    largest: float

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return (
            f"{self.signal} ran away: beyond {self.bound:g}{unit} since t = {self.since:.4g} s, "
            f"up to {self.largest:.3g}{unit}"
        )


def runaways(run: Run, extremes: Mapping[str, Extremes]) -> list[Runaway]:
    """Every recorded signal that ran away, the first one first.

    ``extremes`` are those of each signal, NaN where a row has no number.
    """
    found: list[Runaway] = []
    for name, bound in _bounds_of(run).items():
        low, high = extremes[name]
        if -bound <= low and high <= bound:
            continue
        signal = run[name]
        sizes = np.abs(signal.values)
        away = sizes > bound
        if away.any():
            row = int(np.argmax(away))
            ticks = signal.group.ticks_of(row, row + 1)
            since = float(run.seconds(ticks)[0])
            largest = float(np.fmax.reduce(sizes))
            found.append(Runaway(name, signal.unit, bound, int(ticks[0]), since, largest))
    return sorted(found, key=lambda each: (each.tick, each.signal))


_BOUNDS: WeakKeyDictionary[Run, Mapping[str, float]] = WeakKeyDictionary()


def _bounds_of(run: Run) -> Mapping[str, float]:
    """The bound of each floating-point signal of a run; looked for once."""
    if run not in _BOUNDS:
        signals = run.signals.items()
        _BOUNDS[run] = {n: bound_of(s.unit) for n, s in signals if s.is_float}
    return _BOUNDS[run]
