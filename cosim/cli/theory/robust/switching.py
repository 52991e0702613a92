"""``cohaptic theory robust switching``: delays that switch arbitrarily in a set."""

from __future__ import annotations

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.robust.joint import result_of, sentence
from cosim.cli.theory.support.options import Loop, describe, emit, loop_options
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.network import switching_delays
from cosim.theory.stability.spectral_radius import stability


@click.command(cls=JsonCommand)
@click.option("--delays", metavar="I,J,…", help="Network samples, either way.")
@click.option("--forward-delays", metavar="I,J,…", help="Of the first direction.")
@click.option("--backward-delays", metavar="I,J,…", help="Of the other.")
@click.option(
    "--freshest",
    is_flag=True,
    help="Receivers never go back to an older packet: an age grows by one a period at most.",
)
@loop_options(chapter=6, exact=True)
def command(
    *,
    loop: Loop,
    as_json: bool,
    delays: str | None,
    forward_delays: str | None,
    backward_delays: str | None,
    freshest: bool,
) -> None:
    """Bounds of the joint spectral radius of delays that switch in a set.

    Without a set each direction takes its own delay and one sample more. Below 1 the loop is
    stable whatever the order; above, the order that is named makes it grow, although every one of
    its delays may be stable when it stays.
    """
    forward, backward = _sets(loop, delays, forward_delays, backward_delays)
    automaton, ages = switching_delays(
        loop.model, loop.timing, forward, backward, freshest=freshest
    )
    found = joint_radius(automaton)
    fixed = {
        tuple(one): float(stability(loop.model, loop.timing_at(*one)).spectral_radius)
        for one in sorted({(i, j) for i in forward for j in backward})
    }
    result = {
        **result_of(found, automaton, ages),
        "fixed": [{"forward": i, "backward": j, "radius": r} for (i, j), r in fixed.items()],
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    largest = max(fixed, key=lambda one: fixed[one])
    order = " → ".join(str(ages[number]) for number in found.word)
    text = (
        f"{describe(loop)}\n"
        f"delays forward {_listed(forward)}, backward {_listed(backward)}"
        f"{', the freshest packet wins' if freshest else ''}: {len(ages)} maps\n"
        f"{sentence(found)}\n"
        f"largest known growth: {order} (age on every link), repeated\n"
        f"kept fixed, the largest spectral radius is {fixed[largest]:.6f}, at {largest[0]} forward "
        f"and {largest[1]} backward"
    )
    emit(result, text, as_json=as_json, notes=loop.notes)


def _sets(
    loop: Loop, both: str | None, forward: str | None, backward: str | None
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    own = loop.timing.delay
    if both is not None and (forward is not None or backward is not None):
        raise InputError("Give --delays for either way, or --forward-delays and --backward-delays.")
    given = [text for text in (both, forward, backward) if text is not None]
    if given and own.total and loop.scenario is None:
        raise InputError(
            "A fixed delay and a set of delays contradict each other: leave the fixed one out."
        )
    return (
        _read(both or forward, "--forward-delays", own.forward),
        _read(both or backward, "--backward-delays", own.backward),
    )


def _read(text: str | None, option: str, own: int) -> tuple[int, ...]:
    if text is None:
        return own, own + 1
    try:
        return tuple(sorted({int(part) for part in text.split(",")}))
    except ValueError:
        raise InputError(f"{option} {text}: give whole network samples, such as 0,1,2.") from None


def _listed(ages: tuple[int, ...]) -> str:
    return "{" + ", ".join(map(str, ages)) + "}"
