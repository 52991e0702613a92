"""A run along a parameter: all stable intervals, and how far it is from instability."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.chance import own_chance, with_losses
from cosim.analysis.monodromy.point import Point
from cosim.analysis.monodromy.spectrum import SETTLED
from cosim.analysis.parameter import is_number, parameter
from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.theory.stability.margins import FURTHEST_DELAY, FURTHEST_GAIN, Margins
from cosim.theory.stability.spectral_radius import stable_interval_around, stable_intervals

LINEAR_POINTS, POINTS = 60, 24
"""Samples of a range: a run with an operating point of its own takes longer."""
LARGEST_STEP = 0.15
"""The largest relative change of a parameter from one operating point to the next."""

FINEST, DIFFERENCED = 1e-13, 1e-8
"""How finely the end of a margin is found: differences of small steps know no more."""

COUPLERS = ("virtual_coupler", "distributed_workstation", "central_server")


class _Along:
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
    along = _Along(asked, lambda v: asked.sets(name, v), value)
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


def run_margins(asked: AskedRun) -> Margins:
    """All margins of a run: factors on its couplers, delay and loss.

    Raises:
        InputError: the run itself is unstable.
    """
    radius = deciding_radius(asked.point())
    if own_chance(asked.point()) is None and asked.point().spectrum().verdict == "neutral":
        raise InputError(
            "One motion of this run neither decays nor grows (the first of theory modes), so it "
            "has no margins: have something hold it first."
        )
    if radius >= 1.0 - SETTLED:
        raise InputError(
            f"This run is unstable (spectral radius {radius:.6g}), so it has no margins: "
            "lower the network couplers' stiffness or the delay first."
        )
    far = _far_components(asked.scenario)

    def around_one(wanted: Callable[[str, str], bool]) -> tuple[float, float]:
        paths = _coupler_values(asked.scenario, wanted)
        along = _Along(
            asked, lambda g: [f"{path}={value * g!r}" for path, value in paths.items()], 1.0
        )
        return _around_one(along, linear=asked.point().run.is_linear)

    crosses = any(link.via is not None for link in asked.scenario.connections)
    return Margins(
        stiffness=around_one(lambda _, name: name.endswith("stiffness")),
        damping=around_one(lambda _, name: name.endswith("damping")),
        network=around_one(
            lambda part, name: part in far or name.startswith(("remote_", "coupling_"))
        )
        if crosses
        else None,
        delay=delay_margin(asked) if crosses else None,
        loss=with_losses(asked.point()).critical_loss() if crosses else None,
    )


def _far_components(scenario: Scenario) -> set[str]:
    """The couplers that something comes to through a channel."""
    return {link.target.component for link in scenario.connections if link.via is not None} & {
        name for name, part in scenario.components.items() if part.source == "virtual_coupler"
    }


def _coupler_values(scenario: Scenario, wanted: Callable[[str, str], bool]) -> dict[str, float]:
    """The couplers' stiffness and damping, by path."""
    words = ("local_", "remote_", "coupling_")
    found: dict[str, float] = {}
    for name, part in scenario.components.items():
        if not part.is_bundled or part.source not in COUPLERS:
            continue
        for key in _coupler_names(part.source):
            if (key.startswith(words) or "_" not in key) and wanted(name, key):
                found[f"components.{name}.parameters.{key}"] = parameter(part, key)
    return found


def _coupler_names(model: str) -> list[str]:
    from importlib import import_module

    from fmus.layout import SlotLayout

    layout = SlotLayout(import_module(f"fmus.{model}.variables").MODEL)
    return [
        placed.path
        for placed in layout.placed
        if placed.variable.causality == "parameter"
        and "." not in placed.path
        and placed.path.endswith(("stiffness", "damping"))
    ]


def _around_one(radius: Callable[[float], float], *, linear: bool) -> tuple[float, float]:
    """The stable interval of factors that contains 1, on a logarithmic scale."""
    reach = float(np.log(FURTHEST_GAIN if linear else 8.0))
    points = 60 if linear else 16

    def on_logarithm(x: float) -> float:
        return radius(float(np.exp(x)))

    found = stable_interval_around(
        on_logarithm, 0.0, -reach, reach, points, accuracy=FINEST if linear else DIFFERENCED
    )
    low, high = (0.0, 0.0) if found is None else found
    return float(np.exp(low)), float(np.exp(high))


def delay_margin(asked: AskedRun) -> int | None:
    """How many more network samples of round trip the run stands, each half of them rounded up."""
    for extra in range(1, FURTHEST_DELAY + 1):
        sets: list[str] = []
        for name, channel in asked.scenario.channels.items():
            late = (extra - extra // 2, extra // 2)
            ways = (channel.forward.delay.ticks, channel.backward.delay.ticks)
            forward, backward = (
                ticks + more * channel.period for ticks, more in zip(ways, late, strict=True)
            )
            sets += [f"channels.{name}.{form}=~" for form in ("round_trip_delay", "each_way_delay")]
            sets.append(
                f"channels.{name}.delay={{forward: {forward} ticks, backward: {backward} ticks}}"
            )
        point = asked.fresh(sets)
        stable = deciding_radius(point) < 1.0 - SETTLED
        point.close()
        if not stable:
            return extra - 1
    return None
