"""A run along a parameter: where it is stable."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.chance import own_chance
from cosim.analysis.monodromy.point import Point
from cosim.analysis.parameter import is_number, parameter
from cosim.scenario import Scenario
from cosim.theory.stability.spectral_radius import stable_intervals

LINEAR_POINTS, POINTS = 60, 24
"""Samples of a range: a run with an operating point of its own takes longer."""
LARGEST_STEP = 0.15
"""The largest relative change of a parameter from one operating point to the next."""


class Along:
    """The radius of a run along one number, from operating point to operating point."""

    def __init__(
        self, asked: AskedRun, sets: Callable[[float], Sequence[str]], start: float | None
    ) -> None:
        self._asked = asked
        self._sets = sets
        self._known: dict[float, float] = {}
        self._points: dict[float, Point] = {} if start is None else {start: asked.point()}
        """Where it has been; nothing runs there any more."""

    def __call__(self, value: float) -> float:
        """The radius at a value, asked once."""
        if value not in self._known:
            self._known[value] = self._radius(value)
        return self._known[value]

    def _radius(self, value: float) -> float:
        near = None
        for between in self._way(value):
            sets = self._sets(between)
            near = self._asked.point(sets, near or self._nearest(value))
            if between == value:
                self._known[value] = deciding_radius(near)
                self._points[value] = near
            self._asked.forget(sets)
        return self._known[value]

    def _nearest(self, value: float) -> Point | None:
        start = self._start(value)
        return None if start is None else self._points[start]

    def _start(self, value: float) -> float | None:
        """The nearest of the numbers where it has been."""
        return min(self._points, key=lambda other: _apart(other, value), default=None)

    def _way(self, value: float) -> list[float]:
        """Values on the way from there: a linear run needs none."""
        start = self._start(value)
        if start is None or start <= 0.0 or value <= 0.0 or self._asked.point().run.is_linear:
            return [value]
        apart = np.log(value / start)
        count = max(1, int(np.ceil(abs(apart) / np.log1p(LARGEST_STEP))))
        return [float(start * np.exp(apart * n / count)) for n in range(1, count)] + [value]


def _apart(one: float, other: float) -> float:
    return abs(math.log(one / other)) if one > 0.0 and other > 0.0 else abs(one - other)


def deciding_radius(point: Point) -> float:
    """Of the map; where packets draw their fates, the root of that of the second moments."""
    chance = own_chance(point)
    return point.spectrum().radius if chance is None else math.sqrt(chance.radius())


def intervals_of_run(
    asked: AskedRun, name: str, low: float, high: float
) -> list[tuple[float, float]]:
    """All intervals of a parameter where the run is stable.

    Args:
        asked: the run.
        name: of the parameter.
        low: start of the range.
        high: end of the range.

    Raises:
        InputError: there is no such parameter, or the run has no operating point somewhere.
    """
    value = _value(asked.scenario, asked.paths_of(name)[0])
    along = Along(asked, lambda v: asked.sets(name, v), value)
    points = LINEAR_POINTS if asked.point().run.is_linear else POINTS
    return stable_intervals(along, low, high, points)


def _value(scenario: Scenario, path: str) -> float | None:
    """What a path holds now, where it is a component's parameter."""
    parts = path.split(".", 3)
    if len(parts) == 4 and parts[0] == "components" and parts[1] in scenario.components:
        part = scenario.components[parts[1]]
        value = part.parameters.get(parts[3])
        if part.is_bundled and is_number(value):
            return parameter(part, parts[3])
        return float(value) if isinstance(value, int | float) else None
    return None
