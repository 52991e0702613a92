"""``cohaptic theory radius``: is a loop stable."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.stability.spectral_radius import stability


@click.command(cls=JsonCommand)
@loop_options(chapter=5, runs=True)
def command(loop: Loop | RunLoop, as_json: bool) -> None:
    """Spectral radius over one network period, neutral motions apart: stable below 1.

    With --scenario it is that of the run itself: the compiled plan, perturbed. Where packets are
    lost it is the mean-square radius.
    """
    if isinstance(loop, RunLoop):
        _of_run(loop, as_json=as_json)
        return
    found = stability(loop.model, loop.timing)
    result = {
        "spectral_radius": found.spectral_radius,
        "stable": found.stable,
        "marginal": found.marginal,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    verdict = "stable" if found.stable else "unstable"
    marginal = "\nmarginal: momentum is conserved, the common velocity is left out"
    text = (
        f"{describe(loop)}\n"
        f"spectral radius {found.spectral_radius:.6g}: {verdict}"
        f"{marginal if found.marginal else ''}"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)


def _of_run(loop: RunLoop, *, as_json: bool) -> None:
    from cosim.cli.theory.support.run_answer import of_run, place

    with loop.asked() as asked:
        answer = of_run(asked)
        text = (
            f"{place(asked)}\n{answer.kind} {answer.radius:.6g} over "
            f"{float(answer.period) * 1e3:.6g} ms: {answer.verdict}"
        )
        if answer.verdict == "neutral":
            text += ", one motion neither decays nor grows (the first of theory modes)"
        if answer.marginal:
            text += "\nmarginal: momentum is conserved, the common velocity is left out"
        emit(answer.result(), text, as_json=as_json, notes=asked.notes)
