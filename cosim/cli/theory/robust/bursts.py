"""``cohaptic theory robust bursts``: losses of which only the longest run is known."""

from __future__ import annotations

from typing import get_args

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.robust.joint import result_of, sentence
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.chance.packets import Losses
from cosim.theory.models.frame import HOLD
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.network import bounded_bursts


@click.command(cls=JsonCommand)
@click.option(
    "--longest",
    type=click.IntRange(0, 50),
    default=1,
    show_default=True,
    metavar="L",
    help="Packets that may be lost in a row.",
)
@click.option(
    "--losses",
    type=click.Choice(get_args(Losses)),
    default="independent",
    show_default=True,
    help="Whether the directions lose packets each by itself or together.",
)
@loop_options(chapter=6, runs=True)
def command(*, loop: Loop | RunLoop, as_json: bool, longest: int, losses: Losses) -> None:
    """Bounds of the joint spectral radius of losses in bursts of at most L packets.

    No probability: whichever packets are lost, as long as no more than L in a row are. One
    quadratic norm for each number of packets that are missing. With --scenario the maps are those
    of the run, and the kernel is asked for the losses that are named.
    """
    if isinstance(loop, RunLoop):
        _of_run(loop, longest, losses, as_json=as_json)
        return
    automaton, events = bounded_bursts(loop.model, loop.timing, longest, losses)
    found = joint_radius(automaton)
    said = [["lost" if event == HOLD else "arrives" for event in one] for one in events]
    result = {
        **result_of(found, automaton, events),
        "worst": [said[number] for number in found.word],
        "longest": longest,
        "losses": losses,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    order = " → ".join(f"({', '.join(said[number])})" for number in found.word)
    text = (
        f"{describe(loop)}\n"
        f"at most {longest} lost in a row, {losses}: {automaton.nodes} nodes, "
        f"{len(automaton.edges)} edges\n{sentence(found)}\n"
        f"largest known growth: {order}, repeated"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)


def _of_run(loop: RunLoop, longest: int, losses: Losses, *, as_json: bool) -> None:
    from cosim.analysis.answers.orders import bursts_run
    from cosim.cli.theory.robust.of_run import joint_lines, joint_result
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        orders = bursts_run(asked, longest, losses)
        found = orders.joint_radius()
        growth = orders.kernel_growth(found.word)
        result = {
            **joint_result(orders, found, growth),
            "longest": longest,
            "losses": losses,
            **about(asked),
        }
        lines = [
            place(asked),
            f"at most {longest} lost in a row, {losses}: {len(orders.edges)} edges",
            *joint_lines(orders, found, growth),
        ]
        emit(result, "\n".join(lines), as_json=as_json, notes=asked.notes)
