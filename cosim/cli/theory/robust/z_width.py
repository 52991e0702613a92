"""``cohaptic theory robust z-width``: by rule, by eigenvalues, and as it is built."""

from __future__ import annotations

import json

import click
import numpy as np

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.theory.robust.z_width import RenderedWall, as_built, by_eigenvalues, by_rule


@click.command(cls=JsonCommand)
@click.option(
    "--mass", type=Number(1e-4, 100), default=0.1, show_default=True, metavar="M", help="kg."
)
@click.option(
    "--device-damping",
    type=Number(0, 1e4),
    default=0.1,
    show_default=True,
    metavar="B",
    help="Physical, N·s/m.",
)
@click.option(
    "--control-rate",
    type=Number(1, 1e6),
    default=1024.0,
    show_default=True,
    metavar="HZ",
    help="1 / T_c.",
)
@click.option(
    "--computation-delay",
    type=click.IntRange(0, 50),
    default=0,
    show_default=True,
    metavar="TICKS",
    help="From measurement to force.",
)
@click.option(
    "--count",
    type=Number(0, 0.01),
    default=2e-5,
    show_default=True,
    metavar="M",
    help="Of the encoder, at the tip.",
)
@click.option(
    "--window",
    type=click.IntRange(0, 64),
    default=16,
    show_default=True,
    metavar="TICKS",
    help="Longest window of the velocity (FOAW); 0: true.",
)
@click.option(
    "--most",
    type=Number(0.1, 1e4),
    default=20.0,
    show_default=True,
    metavar="B",
    help="Largest damping of the wall, N·s/m.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    *,
    mass: float,
    device_damping: float,
    control_rate: float,
    computation_delay: int,
    count: float,
    window: int,
    most: float,
    as_json: bool,
) -> None:
    """The stiffest wall over its damping: K < (b + B)/(T/2 + t_d) beside what holds.

    By eigenvalues with the true velocity, and simulated with encoder counts and the estimator.
    """
    device = RenderedWall(
        mass, device_damping, 1.0 / control_rate, computation_delay, count, window
    )
    damping = np.linspace(most / 8, most, 8)
    built = as_built(device, damping)
    rows = [
        {
            "damping": float(one),
            "by_rule": by_rule(device, float(one)),
            "by_eigenvalues": by_eigenvalues(device, float(one)),
            "as_built": float(simulated),
        }
        for one, simulated in zip(damping, built, strict=True)
    ]
    if as_json:
        click.echo(json.dumps({"z_width": rows}))
        return
    click.echo("wall damping  by rule  by eigenvalues  as built (N·s/m, N/m)")
    for row in rows:
        click.echo(
            f"{row['damping']:12.4g} {row['by_rule']:8.0f} {row['by_eigenvalues']:15.0f} "
            f"{row['as_built']:9.0f}"
        )
