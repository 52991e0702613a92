"""How far a run is from instability: factors on its couplers, delay and loss."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.chance import own_chance, with_losses
from cosim.analysis.answers.vary import Along, deciding_radius
from cosim.analysis.monodromy.spectrum import SETTLED
from cosim.analysis.parameter import layout_of, parameter
from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.theory.stability.margins import FURTHEST_DELAY, FURTHEST_GAIN, NOT_LOOKED, Margins
from cosim.theory.stability.spectral_radius import stable_interval_around

FURTHEST_FACTOR = 8.0
"""Factors of a run with an operating point of its own are looked for between 1/8 and 8."""
REFINEMENTS = 5
"""Halvings of a step between a factor with an answer and one without."""
FINEST, DIFFERENCED = 1e-13, 1e-8
"""How finely the end of a margin is found: differences of small steps know no more."""

COUPLERS = ("virtual_coupler", "distributed_workstation", "central_server")


@dataclass(frozen=True, slots=True)
class GainMargin:
    """An interval of factors around 1; of an end that is no instability, why there is no answer."""

    low: float
    high: float
    below: str
    above: str

    @property
    def interval(self) -> tuple[float, float]:
        """Both ends."""
        return self.low, self.high

    @property
    def is_open(self) -> bool:
        """Whether an end is no instability."""
        return bool(self.below or self.above)


def run_margins(asked: AskedRun) -> Margins:
    """All margins of a run: factors on its couplers, delay and loss.

    Raises:
        InputError: the run itself is unstable.
    """
    radius = deciding_radius(asked.point())
    if radius >= 1.0 - SETTLED:
        if own_chance(asked.point()) is None and asked.point().spectrum().verdict == "neutral":
            raise InputError(
                "One motion of this run neither decays nor grows (the first of theory modes), so "
                "it has no margins: have something hold it first."
            )
        raise InputError(
            f"This run is unstable (spectral radius {radius:.6g}), so it has no margins: "
            "lower the network couplers' stiffness or the delay first."
        )
    far = _far_components(asked.scenario)

    def around_one(wanted: Callable[[str, str], bool]) -> GainMargin:
        paths = _coupler_values(asked.scenario, wanted)
        along = Along(
            asked, lambda g: [f"{path}={value * g!r}" for path, value in paths.items()], 1.0
        )
        return _around_one(along, linear=asked.point().run.is_linear)

    crosses = any(link.via is not None for link in asked.scenario.connections)
    found = {
        "stiffness": around_one(lambda _, name: name.endswith("stiffness")),
        "damping": around_one(lambda _, name: name.endswith("damping")),
    }
    if crosses:
        found["network"] = around_one(
            lambda part, name: part in far or name.startswith(("remote_", "coupling_"))
        )
    return Margins(
        stiffness=found["stiffness"].interval,
        damping=found["damping"].interval,
        network=found["network"].interval if crosses else None,
        delay=delay_margin(asked) if crosses else None,
        loss=with_losses(asked.point()).critical_loss() if crosses else None,
        open_ends={n: (each.below, each.above) for n, each in found.items() if each.is_open},
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
    return [
        placed.path
        for placed in layout_of(model).placed
        if placed.variable.causality == "parameter"
        and "." not in placed.path
        and placed.path.endswith(("stiffness", "damping"))
    ]


def _around_one(radius: Callable[[float], float], *, linear: bool) -> GainMargin:
    """The stable interval of factors that contains 1, on a logarithmic scale.

    Raises:
        InputError: there is no answer inside of it.
    """
    furthest = FURTHEST_GAIN if linear else FURTHEST_FACTOR
    reach = float(np.log(furthest))
    points = 60 if linear else 16

    def on_logarithm(x: float) -> float:
        return radius(float(np.exp(x)))

    def within(low: float, high: float) -> tuple[float, float]:
        accuracy = FINEST if linear else DIFFERENCED
        found = stable_interval_around(on_logarithm, 0.0, low, high, points, accuracy=accuracy)
        return (0.0, 0.0) if found is None else found

    below, above = NOT_LOOKED, NOT_LOOKED
    low, high = -reach, reach
    try:
        start, end = within(low, high)
    except InputError:
        low, below = _answered(on_logarithm, low)
        high, above = _answered(on_logarithm, high)
        start, end = within(low, high) if low < high else (0.0, 0.0)
    return GainMargin(
        float(np.exp(start)),
        float(np.exp(end)),
        below if start <= low else "",
        above if end >= high else "",
    )


def _answered(radius: Callable[[float], float], end: float) -> tuple[float, str]:
    """How far from 0 towards ``end`` there are answers, or the run is stable; why no further."""
    known, why = 0.0, ""
    for further in np.linspace(0.0, end, 9)[1:].tolist():
        try:
            if radius(further) >= 1.0:
                return further, ""
        except InputError as error:
            refused, why = further, str(error)
            break
        known = further
    else:
        return end, NOT_LOOKED
    for _ in range(REFINEMENTS):
        middle = (known + refused) / 2
        try:
            if radius(middle) >= 1.0:
                return middle, ""
            known = middle
        except InputError as error:
            refused, why = middle, str(error)
    return known, why


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
