"""``cohaptic theory margins``: how far a loop is from instability."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.stability.margins import Margins, margins


@click.command(cls=JsonCommand)
@loop_options(chapter=5, runs=True)
def command(loop: Loop | RunLoop, as_json: bool) -> None:
    """Margins at a design point: factors on stiffness, damping, network gain; delay; loss."""
    if isinstance(loop, RunLoop):
        _of_run(loop, as_json=as_json)
        return
    found = margins(loop.model, loop.timing)
    result = {
        **_numbers(found),
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    text = "\n".join([describe(loop), *_lines(found)])
    emit(result, text, as_json=as_json, notes=loop.notes)


def _of_run(loop: RunLoop, *, as_json: bool) -> None:
    from cosim.analysis.answers.vary import run_margins
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        found = run_margins(asked)
        text = "\n".join([place(asked), *_lines(found)])
        emit({**_numbers(found), **about(asked)}, text, as_json=as_json, notes=asked.notes)


def _numbers(found: Margins) -> dict[str, object]:
    return {
        "stiffness": list(found.stiffness),
        "damping": list(found.damping),
        "network": None if found.network is None else list(found.network),
        "delay": found.delay,
        "critical_loss": found.loss,
    }


def _lines(found: Margins) -> list[str]:
    lines = [
        f"stable with every stiffness times {_span(found.stiffness)}",
        f"stable with every damping times {_span(found.damping)}",
    ]
    if found.network is not None:
        lines.append(f"stable with all that the network carries times {_span(found.network)}")
        lines.append(
            "stable with any delay tried, up to 64 samples more"
            if found.delay is None
            else f"stable with up to {found.delay} network samples of round trip more"
        )
        loss = "none below 0.999" if found.loss is None else f"{found.loss:.4g}"
        lines.append(f"critical loss: {loss}")
    return lines


def _span(interval: tuple[float, float]) -> str:
    return f"{interval[0]:.4g} to {interval[1]:.4g}"
