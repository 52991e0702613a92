"""``cohaptic theory robust ports``: the loop as a two-port between its users."""

from __future__ import annotations

import math

import click
import numpy as np

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.theory.robust.transparency import PassiveHand, lawrence, yokokohji
from cosim.theory.robust.two_port import default_frequencies, two_port


@click.command(cls=JsonCommand)
@click.option(
    "--hand-stiffness",
    type=Number(0, 1e5),
    default=300.0,
    show_default=True,
    metavar="K",
    help="Of both hands, N/m.",
)
@click.option(
    "--hand-damping",
    type=Number(0, 1e4),
    default=8.0,
    show_default=True,
    metavar="B",
    help="Of both hands, N·s/m.",
)
@click.option(
    "--highest",
    type=Number(1, 1e5),
    default=100.0,
    show_default=True,
    metavar="W",
    help="ω_m of Yokokohji's indices, rad/s.",
)
@click.option(
    "--lag",
    type=Number(0, 10),
    default=0.01,
    show_default=True,
    metavar="T",
    help="Of their weight 1/|1 + jωT|, s.",
)
@loop_options(chapter=6, exact=True)
def command(
    *,
    loop: Loop,
    as_json: bool,
    hand_stiffness: float,
    hand_damping: float,
    highest: float,
    lag: float,
) -> None:
    """Llewellyn's absolute stability, and the indices of transparency.

    Absolutely stable: stable whichever passive hands hold on to it. Otherwise the damping at both
    ports that would make it so.
    """
    frequencies = default_frequencies(loop.timing)
    if highest > frequencies[-1]:
        raise InputError(
            f"--highest {highest:g}: the network's period shows up to {frequencies[-1]:.6g} rad/s."
        )
    port = two_port(loop.model, loop.timing, frequencies)
    parameter = port.llewellyn()
    absolutely = port.absolutely_stable()
    worst = int(np.argmin(parameter))
    needed = port.damping_for_absolute_stability()
    hand = PassiveHand(0.0, hand_damping, hand_stiffness)
    felt = lawrence(port, hand)
    alike = yokokohji(port, hand, hand, highest, lag)
    shown = [0.5, 5.0, 50.0]
    places = [int(np.argmin(np.abs(frequencies - w))) for w in shown]
    impedances = [
        {
            "frequency": float(frequencies[place]),
            "free": float(abs(felt.free[place])),
            "held": float(abs(felt.held[place])),
            "terminated": float(abs(felt.terminated[place])),
        }
        for place in places
    ]
    smallest = float(parameter[worst])
    result = {
        "stable": port.stable,
        "absolutely_stable": absolutely,
        "stability_parameter": smallest if math.isfinite(smallest) else None,
        "frequency": float(frequencies[worst]),
        "port_damping_needed": needed,
        "impedances": impedances,
        "position_index": alike.position,
        "force_index": alike.force,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    place = f"at {frequencies[worst]:.4g} rad/s"
    if not port.stable:
        verdict = "unstable with nothing at its ports"
    elif absolutely:
        verdict = f"absolutely stable; the least stability parameter is {smallest:.6g}, {place}"
    elif math.isfinite(smallest):
        verdict = f"only conditionally stable: the stability parameter is {smallest:.6g} {place}"
    else:
        verdict = f"only conditionally stable: a port alone is active, first {place}"
    lines = [
        describe(loop),
        verdict,
        f"damping at both ports for absolute stability: {needed:.4g} N·s/m",
        *(
            f"at {one['frequency']:.3g} rad/s user 1 feels {one['free']:.4g} N·s/m with the other "
            f"hand free, {one['terminated']:.4g} in the hand's, {one['held']:.4g} with it held"
            for one in impedances
        ),
        f"Yokokohji's J_p {alike.position:.4g} (m/N)·(rad/s), J_f {alike.force:.4g} rad/s",
    ]
    emit(result, "\n".join(lines), as_json=as_json, notes=loop.notes)
