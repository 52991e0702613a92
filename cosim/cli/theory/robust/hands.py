"""``cohaptic theory robust hands``: every hand of given intervals."""

from __future__ import annotations

import click
import numpy as np

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.reading import read_range
from cosim.theory.robust.hands import Interval, robustness, uncertain_hands


@click.command(cls=JsonCommand)
@click.option("--hand-mass", metavar="LOW:HIGH", help="kg, hand and device.")
@click.option("--hand-stiffness", metavar="LOW:HIGH", help="N/m, sampled at T_c.")
@click.option("--hand-damping", metavar="LOW:HIGH", help="N·s/m, sampled at T_c.")
@click.option(
    "--frequencies",
    type=click.IntRange(2, 400),
    default=24,
    show_default=True,
    metavar="COUNT",
    help="From 1 rad/s to half the network rate.",
)
@loop_options(chapter=6, exact=True)
def command(
    *,
    loop: Loop,
    as_json: bool,
    hand_mass: str | None,
    hand_stiffness: str | None,
    hand_damping: str | None,
    frequencies: int,
) -> None:
    """An upper bound of μ over all hands in intervals, and the worst corner of them.

    Every hand has its own mass, stiffness and damping. With μ below 1 the loop is stable with all
    of them; 1/μ of the intervals, from their middle, is proved in any case. The bound is taken on
    a grid of frequencies.
    """
    texts = {"mass": hand_mass, "stiffness": hand_stiffness, "damping": hand_damping}
    intervals: dict[str, Interval] = {
        name: read_range(text, f"--hand-{name}", "0.07:0.13")
        for name, text in texts.items()
        if text is not None
    }
    uncertain = uncertain_hands(loop.model, loop.timing, intervals)
    grid = np.geomspace(1.0, np.pi / float(loop.timing.network_period), frequencies)
    found = robustness(uncertain, grid)
    result = {
        "verdict": found.verdict,
        "mu": found.bound,
        "frequency": found.frequency,
        "middle_radius": found.nominal,
        "worst_radius": found.worst,
        "worst": dict(found.corner),
        "intervals": {name: list(one) for name, one in intervals.items()},
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    corner = ", ".join(f"{name} {value:.4g}" for name, value in found.corner.items())
    said = {
        "stable": "stable with all of them",
        "unstable": "unstable with some",
        "undecided": "no corner is unstable, and not all of the intervals is proved",
    }
    text = (
        f"{describe(loop)}\n"
        f"μ at most {found.bound:.4g} (at {found.frequency:.4g} rad/s), ρ in the middle "
        f"{found.nominal:.6g}: {said[found.verdict]}\n"
        f"worst corner: ρ = {found.worst:.6g} with {corner}"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)
