"""``cohaptic theory margins``: how far a loop is from instability."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.options import Loop, describe, emit, loop_options
from cosim.theory.stability.margins import margins


@click.command(cls=JsonCommand)
@loop_options(chapter=5)
def command(loop: Loop, as_json: bool) -> None:
    """Margins at a design point: factors on stiffness, damping, network gain; delay; loss."""
    found = margins(loop.model, loop.timing)
    result = {
        "stiffness": list(found.stiffness),
        "damping": list(found.damping),
        "network": None if found.network is None else list(found.network),
        "delay": found.delay,
        "critical_loss": found.loss,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    lines = [
        describe(loop),
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
    emit(result, "\n".join(lines), as_json=as_json, notes=loop.notes)


def _span(interval: tuple[float, float]) -> str:
    return f"{interval[0]:.4g} to {interval[1]:.4g}"
