"""How long the way between stations may be before the theory calls the loop unstable."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cosim.analysis.loop import read_loop
from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay
from cosim.theory.stability.spectral_radius import stability

FURTHEST = 64
"""Samples each way beyond which nothing is asked: half a second at 128 Hz."""


@dataclass(frozen=True, slots=True)
class LongestDelay:
    """The largest delay of both directions, in network samples, up to which the loop is stable.

    ``samples`` is 0 where it is unstable at one sample; ``bounded`` is false where it is stable as
    far as was asked.
    """

    samples: int
    bounded: bool


def longest_delay(scenario: Scenario) -> LongestDelay | None:
    """The longest delay each way that the scenario's loop stands, everyone holding on.

    ``None`` where chapters 3 to 6 do not know its loop.
    """
    try:
        loop = read_loop(scenario)
        model = Parameters(loop.architecture, loop.values, {}, users=loop.users).model()
    except InputError:
        return None  # a mass of zero, say, which its FMU refuses at its place
    for samples in range(1, FURTHEST + 1):
        timing = replace(loop.timing, delay=PathDelay.each_way(samples))
        if not stability(model, timing).stable:
            return LongestDelay(samples - 1, bounded=True)
    return LongestDelay(FURTHEST, bounded=False)
