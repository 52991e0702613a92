"""``cohaptic theory damping``: the viscous friction that a user feels, and what nulls it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, get_args

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import DampingModel

if TYPE_CHECKING:
    from cosim.analysis.answers.asked import AskedRun
    from cosim.analysis.monodromy.spectrum import RunSpectrum

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
@click.option("--user", metavar="NAME", help="With --scenario: the hand or operator that feels it.")
@loop_options(chapter=6, runs=True)
def command(
    loop: Loop | RunLoop, as_json: bool, kind: DampingModel, all_hands: bool, user: str | None
) -> None:
    """DC damping b = lim F/V, and the compensation b_c per object copy that nulls it.

    Centralized: the remote user feels it. One user holds the object, as in Fig. 6.1; --all-hands
    lets the others hold it as well. The compensation is the value of an object's parameter:
    negative compensates. With --scenario everybody holds it as in the run; in a planar one a user's
    fingers carry the grasp together along x and y, without what the hands' own springs and
    dampers add.
    """
    if isinstance(loop, RunLoop):
        if kind != "original":
            raise InputError(
                "--model simplified has no hands, and a run has those of its scenario."
            )
        if all_hands:
            raise InputError(
                "--all-hands is of the closed forms: in a run everybody holds the object as the "
                "scenario says. Leave it out."
            )
        _of_run(loop, user, as_json=as_json)
        return
    if user is not None:
        raise InputError("--user names a hand of a scenario: give --scenario FILE too.")
    felt_by = FELT_BY[loop.architecture]
    model = loop.model if all_hands else loop.one_hand(felt_by)
    found = null_compensation(model, loop.timing, felt_by, kind)
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
        f"damping {found.damping:.6g} N·s/m, felt by user {felt_by + 1} ({kind} model){warning}\n"
        f"compensation b_c {found.value:.6g} N·s/m per object copy nulls it; the compensated loop "
        f"is {verdict} (spectral radius {found.compensated.spectral_radius:.6g} beside the common "
        "motion)"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)


def _of_run(loop: RunLoop, user: str | None, *, as_json: bool) -> None:
    from cosim.analysis.monodromy.refusal import refuse_chance

    with loop.asked() as asked:
        refuse_chance(asked.scenario, "damping is")
        answer = _of_one_axis if asked.point().run.is_linear else _of_grasp
        result, text = answer(asked, user)
        emit(result, text, as_json=as_json, notes=asked.notes)


def _of_one_axis(asked: AskedRun, user: str | None) -> tuple[dict[str, Any], str]:
    from cosim.analysis.answers.felt import null_run_damping
    from cosim.analysis.answers.push import find_push
    from cosim.cli.theory.support.run_answer import about, place

    number = 1 if about(asked)["architecture"] == "centralized" else 0
    push = find_push(asked.scenario, user, number=number)
    as_it_is = asked.point().spectrum()
    found = null_run_damping(asked, push)
    result = {
        "damping": found.damping,
        "compensation": found.value,
        "stable": as_it_is.stable,
        "compensated_spectral_radius": found.radius,
        "compensated_stable": found.verdict == "stable",
        "compensated_marginal": found.marginal,
        "user": push.hand,
        "model": "original",
        **about(asked),
    }
    text = (
        f"{place(asked)}\n"
        f"damping {found.damping:.6g} N·s/m, felt by {push.hand}{_warning(as_it_is)}\n"
        f"compensation b_c {found.value:.6g} N·s/m per object copy nulls it; the compensated "
        f"run is {found.verdict} (spectral radius "
        f"{found.radius:.6g} beside the common motion)"
    )
    return result, text


def _of_grasp(asked: AskedRun, user: str | None) -> tuple[dict[str, Any], str]:
    from cosim.analysis.answers.grasp_damping import null_grasp_damping
    from cosim.cli.theory.support.run_answer import about, place

    as_it_is = asked.point().spectrum()
    found = null_grasp_damping(asked, user)
    result = {
        "damping": dict(found.damping),
        "compensation": dict(found.compensation),
        "stable": as_it_is.stable,
        "compensated_spectral_radius": found.radius,
        "compensated_stable": found.verdict == "stable",
        "user": list(found.operators),
        "model": "original",
        **about(asked),
    }
    felt, nulls = (
        ", ".join(f"{value:.5g} N·s/m along {axis}" for axis, value in values.items())
        for values in (found.damping, found.compensation)
    )
    text = (
        f"{place(asked)}\n"
        f"damping {felt}, felt by {' and '.join(found.operators)} together, hands apart"
        f"{_warning(as_it_is)}\n"
        f"compensation b_c {nulls} per copy of the box nulls it; with the hands the compensated "
        f"run is {found.verdict} (spectral radius {found.radius:.6g})"
    )
    return result, text


def _warning(found: RunSpectrum) -> str:
    if found.verdict == "unstable":
        return "; the run itself is unstable, so nobody will feel it"
    return "" if found.stable else "; a motion of the run itself neither decays nor grows"
