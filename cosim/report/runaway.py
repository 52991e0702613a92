"""Signals that have run away: numbers, but no longer those of hands, boxes and motors.

An unstable loop gives finite values for a long time; they only grow. What a haptic bench can reach
is known, so a signal far beyond that is told, however the loop came to diverge. Decision 203 has
the bounds' reasons and what a run that ran away stands for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from cosim.record.reader import Run
from cosim.report.expectation import Expectation
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


@dataclass(frozen=True, slots=True)
class Runaway:
    """One signal that left its bound: since when (s), and how far it came."""

    signal: str
    unit: str
    bound: float
    since: float
    largest: float

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return (
            f"{self.signal} ran away: beyond {self.bound:g}{unit} since t = {self.since:.4g} s, "
            f"up to {self.largest:.3g}{unit}"
        )


def runaways(
    run: Run, extremes: Mapping[str, Extremes], expectations: Iterable[Expectation] = ()
) -> list[Runaway]:
    """Every recorded signal that ran away, the first one first.

    ``extremes`` are those of each signal. A signal that the scenario has an
    expectation of is judged by that alone.
    """
    far = {
        name: size
        for name, bound in _bounds_of(run).items()
        if (size := max(-extremes[name][0], extremes[name][1])) > bound
    }
    for each in expectations if far else ():
        for name in each.target.signals if each.target is not None else ():
            far.pop(name, None)
    found: list[Runaway] = []
    for name, size in far.items():
        signal, bound = run[name], _bounds_of(run)[name]
        row = int(np.argmax(np.abs(signal.values) > bound))
        since = float(run.seconds(signal.group.ticks_of(row, row + 1))[0])
        found.append(Runaway(name, signal.unit, bound, since, size))
    return sorted(found, key=lambda each: (each.since, each.signal))


_BOUNDS: WeakKeyDictionary[Run, Mapping[str, float]] = WeakKeyDictionary()


def _bounds_of(run: Run) -> Mapping[str, float]:
    """The bound of each floating-point signal of a run; looked for once."""
    if run not in _BOUNDS:
        signals = run.signals.items()
        _BOUNDS[run] = {n: BOUNDS.get(s.unit, OTHERWISE) for n, s in signals if s.is_float}
    return _BOUNDS[run]
