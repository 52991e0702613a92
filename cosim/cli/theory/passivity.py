"""``cohaptic theory passivity``: what a device with physical damping can render passively."""

from __future__ import annotations

import click
import numpy as np

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.theory.stability.passivity import damping_for_passivity, passive_stiffness


@click.command(cls=JsonCommand)
@click.option(
    "--device-damping",
    type=Number(0, 1e6),
    required=True,
    metavar="B",
    help="Physical damping, N·s/m.",
)
@loop_options(chapter=5)
def command(loop: Loop, as_json: bool, device_damping: float) -> None:
    """Passivity and Z-width of the coupler that a user feels, velocity by backward difference.

    The local coupler (k, k_1, k_11) is rendered at T_c with the computation delay; the remote
    user's of the centralized loop (k_2) at T_t with the round trip.
    """
    timing, parameters = loop.timing, loop.parameters
    remote = loop.architecture == "centralized"
    names = {"single": ("k", "b"), "centralized": ("k_2", "b_2"), "distributed": ("k_11", "b_11")}
    stiffness, damping = (parameters[name] for name in names[loop.architecture])
    period = float(timing.network_period if remote else timing.control_period)
    delay = timing.delay.total if remote else timing.computation_delay
    needed = damping_for_passivity(stiffness, damping, period, delay)
    limit = passive_stiffness(device_damping, damping, period, delay)
    width: list[list[float]] = []
    for coupler_damping in np.linspace(0.0, device_damping, 21):
        highest = passive_stiffness(device_damping, float(coupler_damping), period, delay)
        if highest is not None:
            width.append([float(coupler_damping), highest])
    result = {
        "passive": needed < device_damping,
        "needed_device_damping": needed,
        "passive_stiffness": limit,
        "z_width": width,
        "architecture": loop.architecture,
        "parameters": parameters.resolved(),
    }
    verdict = "passive" if needed < device_damping else "not passive"
    most = f"up to {limit:.6g} N/m" if limit is not None else "no stiffness at all"
    text = (
        f"{describe(loop)}\n"
        f"{names[loop.architecture][0]} = {stiffness:g} N/m with {damping:g} N·s/m needs "
        f"{needed:.6g} N·s/m of physical damping: {verdict} on a device with {device_damping:g}\n"
        f"with {damping:g} N·s/m in the coupler, this device renders {most} passively"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)
