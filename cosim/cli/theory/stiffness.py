"""``cohaptic theory stiffness``: what a user feels when the object meets a rigid wall."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.theory.models.parameters import WALL
from cosim.theory.transparency.stiffness import distributed_stiffness, equivalent_stiffness


@click.command(cls=JsonCommand)
@loop_options(chapter=6)
def command(loop: Loop, as_json: bool) -> None:
    """Equivalent stiffness at equilibrium against a wall (k_w = 30000 N/m unless set)."""
    walls = {name: value for name, value in WALL.items() if name not in loop.parameters.given}
    touching = Loop(loop.parameters.replaced(walls), loop.timing, loop.notes)
    parameters = touching.parameters
    result: dict[str, object] = {}
    if loop.architecture == "centralized":
        local = equivalent_stiffness(touching.one_hand(0), 0)
        remote = equivalent_stiffness(touching.one_hand(1), 1)
        result = {"stiffness": remote, "local": local, "remote": remote}
        lines = [f"remote user {remote:.6g} N/m", f"local user {local:.6g} N/m"]
    else:
        felt = equivalent_stiffness(touching.one_hand(0), 0)
        result = {"stiffness": felt}
        lines = [f"{felt:.6g} N/m"]
    if loop.architecture == "distributed" and parameters.users == 2:
        closed = distributed_stiffness(
            parameters["k_11"], parameters["k_21"], parameters["k_o1"], parameters["k_w"]
        )
        result["as_printed"] = closed.as_printed
        lines.append(f"(6.4) as printed, with its sign slip: {closed.as_printed:.6g} N/m")
    result |= {
        "ideal": parameters["k_w"],
        "architecture": loop.architecture,
        "parameters": parameters.resolved(),
    }
    lines.append(f"ideal: the wall's own {parameters['k_w']:.6g} N/m")
    text = "\n".join([describe(touching), *lines])
    emit(result, text, as_json=as_json, notes=loop.notes)
