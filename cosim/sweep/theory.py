"""What the theory says about the points of a sweep, to be laid over what the runs say."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.sweep.planning.axis import Value
from cosim.sweep.work.variants import Variants

ROUNDING = 1e-12
"""A spectral radius of 1 within this is neutral, not growing."""


def spectral_radius(scenario: Scenario) -> float:
    """The spectral radius of a scenario's loop over one network period; below 1 it is stable.

    Raises:
        InputError: the scenario has no loop that chapters 3 to 6 know, its packets are lost or late
            by chance, something is turned while it runs, or a delay is no whole number of samples.
    """
    from cosim.analysis.loop import ROUNDED, read_loop
    from cosim.analysis.monodromy.refusal import refuse_chance, refuse_turned
    from cosim.theory.models.parameters import Parameters
    from cosim.theory.stability.spectral_radius import stability

    refuse_chance(scenario, "a spectral radius is")
    refuse_turned(scenario)
    loop = read_loop(scenario)
    for note in loop.notes:
        if ROUNDED in note:
            raise InputError(f"{note} What runs would be another loop.")
    model = Parameters(loop.architecture, loop.values, {}, users=loop.users).model()
    return stability(model, loop.timing).spectral_radius


def radii(variants: Variants, points: Sequence[Sequence[Value]]) -> list[float] | None:
    """The spectral radius at each point, or ``None`` where the theory does not know the loop."""
    found: list[float] = []
    for point in points:
        try:
            found.append(spectral_radius(variants.scenario(point)))
        except InputError:
            return None
    return found


def is_stable(radius: float) -> bool:
    """Whether a loop of this spectral radius settles."""
    return radius < 1.0 - ROUNDING
