"""``cohaptic theory radius``: is a loop stable."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.options import Loop, describe, emit, loop_options
from cosim.theory.stability.spectral_radius import stability


@click.command(cls=JsonCommand)
@loop_options(chapter=5)
def command(loop: Loop, as_json: bool) -> None:
    """Spectral radius over one network period, neutral motions apart: stable below 1."""
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
