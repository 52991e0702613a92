"""What keeps a design's couplers from being stiffer: each cause taken away in turn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from cosim.theory.chance.network import Network
from cosim.theory.chance.packets import LinkProcess, bernoulli, independent_frames
from cosim.theory.design.corners import EDGE, Corner, radius_in
from cosim.theory.design.judge import CornerJudge
from cosim.theory.models.timing import PathDelay, Timing

CAUSES = ("loss", "jitter", "delay", "network rate", "control rate")
"""What can be in the way of more stiffness."""


def worst_cause(causes: Mapping[str, float]) -> str:
    """The cause that costs most; ``itself`` where none matters."""
    worst = max(causes, key=lambda cause: causes[cause])
    return worst if causes[worst] > 1.1 else "itself"


def reliefs(
    judge: CornerJudge, gains: Mapping[str, float], name: str, margin: float
) -> dict[str, float]:
    """By what factor one stiffness could be larger with one cause gone, for every cause.

    The others are taken back by a tenth, so that what is measured is not their own limits. Judged
    with every gain times 1 + m.
    """
    more = 1.0 + margin
    steady = replace(judge.network, jitter=0.0)
    eased = {n: v * (0.9 if n[0] == "k" and n != name else 1.0) for n, v in gains.items()}
    lossy = Corner("", stiffness=more, damping=more, loses=True)

    def growth(network: Network, timing: Timing) -> float:
        exact = network.process()
        process: LinkProcess = independent_frames(exact) if network.jitter else exact
        corner = lossy if network.loss or network.jitter else replace(lossy, loses=False)
        low, high = 0.0, math.log(64.0)
        for _ in range(6):
            middle = (low + high) / 2
            trial = judge.parameters.replaced({**eased, name: eased[name] * math.exp(middle)})
            quick = replace(corner, loses=False)
            stable = radius_in(quick, trial, timing, bernoulli(0.0, 0), 0.0) < EDGE and (
                not corner.loses or radius_in(corner, trial, timing, process, 0.0) < EDGE
            )
            low, high = (middle, high) if stable else (low, middle)
        return math.exp(low)

    as_it_is = growth(steady, judge.timing)
    found: dict[str, float] = {}
    for cause in CAUSES:
        if cause == "jitter":
            jittery = len(judge.process.events) > 2
            found[cause] = as_it_is / growth(judge.network, judge.timing) if jittery else 1.0
            continue
        network, timing = _without(cause, steady, judge.timing)
        same = (network, timing) == (steady, judge.timing)
        found[cause] = 1.0 if same else growth(network, timing) / as_it_is
    return found


def _without(cause: str, network: Network, timing: Timing) -> tuple[Network, Timing]:
    """The network and the rates with one cause gone."""
    better, clock = network.without(cause), timing
    if cause in {"delay", "network rate"}:
        clock = replace(clock, delay=PathDelay())
    if cause == "network rate":
        better = Network(timing.control_period, 0.0, 0.0, network.loss)
        clock = replace(clock, ratio=Fraction(1))
    if cause == "control rate":
        clock = replace(clock, control_period=clock.control_period / 2, ratio=clock.ratio * 2)
    return better, clock
