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
    from cosim.analysis.answers.run_margins import run_margins
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
        "open_ends": {name: list(why) for name, why in found.open_ends.items()},
    }


def _lines(found: Margins) -> list[str]:
    lines = [
        *_span(found, "stiffness", "every stiffness", found.stiffness),
        *_span(found, "damping", "every damping", found.damping),
    ]
    if found.network is not None:
        lines += _span(found, "network", "all that the network carries", found.network)
        lines.append(
            "stable with any delay tried, up to 64 samples more"
            if found.delay is None
            else f"stable with up to {found.delay} network samples of round trip more"
        )
        loss = "none below 0.999" if found.loss is None else f"{found.loss:.4g}"
        lines.append(f"critical loss: {loss}")
    return lines


def _span(found: Margins, name: str, what: str, interval: tuple[float, float]) -> list[str]:
    lines = [f"stable with {what} times {interval[0]:.4g} to {interval[1]:.4g}"]
    for side, end, why in zip(
        ("below", "above"), interval, found.open_ends.get(name, ("", "")), strict=True
    ):
        if why:
            lines.append(f"  no answer {side} {end:.4g}: {why}")
    return lines
