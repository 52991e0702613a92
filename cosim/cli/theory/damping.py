"""``cohaptic theory damping``: the viscous friction that a user feels, and what nulls it."""

from __future__ import annotations

from typing import get_args

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.options import Loop, describe, emit, loop_options
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import DampingModel

FELT_BY = {"single": 0, "centralized": 1, "distributed": 0}
"""Who feels it, by architecture: the remote user of the centralized loop, user 1 of the others."""


@click.command(cls=JsonCommand)
@click.option(
    "--model",
    "kind",
    type=click.Choice(get_args(DampingModel)),
    default="original",
    show_default=True,
    help="With the hands (Fig. 6.1) or with the forces directly on the objects (Fig. 6.3).",
)
@click.option("--all-hands", is_flag=True, help="Every user holds the object, not one alone.")
@loop_options(chapter=6)
def command(loop: Loop, as_json: bool, kind: DampingModel, all_hands: bool) -> None:
    """DC damping b = lim F/V, and the compensation b_c per object copy that nulls it.

    Centralized: the remote user feels it. One user holds the object, as in Fig. 6.1; --all-hands
    lets the others hold it as well. The compensation is the value of an object's parameter:
    negative compensates.
    """
    user = FELT_BY[loop.architecture]
    model = loop.model if all_hands else loop.one_hand(user)
    found = null_compensation(model, loop.timing, user, kind)
    as_it_is = stability(model, loop.timing)
    result = {
        "damping": found.damping,
        "compensation": found.value,
        "stable": as_it_is.stable,
        "compensated_spectral_radius": found.compensated.spectral_radius,
        "compensated_stable": found.compensated.stable,
        "compensated_marginal": found.compensated.marginal,
        "model": kind,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    warning = "" if as_it_is.stable else "; the loop itself is unstable, so nobody will feel it"
    verdict = "stable" if found.compensated.stable else "unstable"
    text = (
        f"{describe(loop)}\n"
        f"damping {found.damping:.6g} N·s/m, felt by user {user + 1} ({kind} model){warning}\n"
        f"compensation b_c {found.value:.6g} N·s/m per object copy nulls it; the compensated loop "
        f"is {verdict} (spectral radius {found.compensated.spectral_radius:.6g} beside the common "
        "motion)"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)
