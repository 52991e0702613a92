"""Whether a scenario is the loop of chapters 3 to 6 that it was read as, asked of its run."""

from __future__ import annotations

from cosim.analysis.answers.asked import ask
from cosim.analysis.monodromy.refusal import refuse_chance
from cosim.analysis.single_axis import ScenarioLoop
from cosim.base.errors import InputError
from cosim.scenario.load import Written
from cosim.theory.models.parameters import Parameters
from cosim.theory.stability.spectral_radius import stability

SAME = 1e-8
"""How far the radius of the loop and of the run may lie apart."""


def refuse_another_loop(written: Written, loop: ScenarioLoop) -> None:
    """Refuse a scenario whose run is not the loop that it was read as.

    Raises:
        InputError: with both radii, or by what the channels do by chance.
    """
    scenario = written.built()
    refuse_chance(scenario, "bounds for any order or any hand are of the fixed delays")
    model = Parameters(loop.architecture, loop.values, {}, loop.users).model()
    wanted = stability(model, loop.timing).spectral_radius
    with ask(written) as asked:
        found = asked.point().spectrum().radius
    if abs(found - wanted) > SAME * max(1.0, wanted):
        raise InputError(
            f"{scenario.name} is no loop of chapters 3 to 6: its run has a spectral radius of "
            f"{found:.9g}, and its normal axis with one finger a user {wanted:.9g}. 'theory "
            "robust' answers for such loops: give one by --architecture and --set, or ask 'theory "
            "radius', 'loss' or 'margins', which answer for the run."
        )
