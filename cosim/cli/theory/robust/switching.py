"""``cohaptic theory robust switching``: delays that switch arbitrarily in a set."""

from __future__ import annotations

from collections.abc import Sequence

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.robust.joint import result_of, sentence
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
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
    help="Receivers never go back to an older packet: an age grows by one a period at most. "
    "Those of a scenario always do so.",
)
@loop_options(chapter=6, runs=True)
def command(
    *,
    loop: Loop | RunLoop,
    as_json: bool,
    delays: str | None,
    forward_delays: str | None,
    backward_delays: str | None,
    freshest: bool,
) -> None:
    """Bounds of the joint spectral radius of delays that switch in a set.

    Without a set each direction takes its own delay and one sample more. Below 1 the loop is
    stable whatever the order; above, the order that is named makes it grow, although every one of
    its delays may be stable when it stays. With --scenario the maps are those of the run; without
    a set a channel with jitter takes every delay that this makes, and the kernel is asked for the
    order that is named.
    """
    if delays is not None and (forward_delays is not None or backward_delays is not None):
        raise InputError("Give --delays for either way, or --forward-delays and --backward-delays.")
    ways = (
        _read(delays or forward_delays, "--forward-delays"),
        _read(delays or backward_delays, "--backward-delays"),
    )
    if isinstance(loop, RunLoop):
        if freshest:
            raise InputError(
                "The receivers of a scenario keep the freshest packet in any case: leave "
                "--freshest out."
            )
        _of_run(loop, *ways, as_json=as_json)
        return
    own = loop.timing.delay
    if any(way is not None for way in ways) and own.total:
        raise InputError(
            "A fixed delay and a set of delays contradict each other: leave the fixed one out."
        )
    forward, backward = (
        (delay, delay + 1) if way is None else way
        for way, delay in zip(ways, (own.forward, own.backward), strict=True)
    )
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


def _of_run(
    loop: RunLoop,
    forward: tuple[int, ...] | None,
    backward: tuple[int, ...] | None,
    *,
    as_json: bool,
) -> None:
    from cosim.analysis.answers.orders import switching_run
    from cosim.cli.theory.robust.of_run import joint_lines, joint_result
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        orders = switching_run(asked, forward, backward)
        with orders.point as point:
            period = point.run.hyperperiod
            found = orders.joint_radius()
            growth = orders.kernel_growth(found.word)
            fixed = {
                tuple(ticks / period for ticks in delays): radius
                for delays, radius in orders.fixed().items()
            }
            largest = max(fixed, key=lambda one: fixed[one])
            result = {
                **joint_result(orders, found, growth),
                "fixed": [
                    {"delays": list(delays), "radius": radius} for delays, radius in fixed.items()
                ],
                **about(asked),
            }
            at = ", ".join(f"{delay:g}" for delay in largest)
            lines = [
                place(asked),
                "delays "
                + ", ".join(
                    f"{link} {_listed([ticks / period for ticks in ticks_of])}"
                    for link, ticks_of in zip(orders.links, orders.ticks, strict=True)
                )
                + f", the freshest packet wins: {len(orders.maps.outcomes)} maps",
                *joint_lines(orders, found, growth),
                f"kept fixed, the largest spectral radius is {fixed[largest]:.6f}, at {at}",
            ]
            emit(result, "\n".join(lines), as_json=as_json, notes=asked.notes)


def _read(text: str | None, option: str) -> tuple[int, ...] | None:
    if text is None:
        return None
    try:
        return tuple(sorted({int(part) for part in text.split(",")}))
    except ValueError:
        raise InputError(f"{option} {text}: give whole network samples, such as 0,1,2.") from None


def _listed(ages: Sequence[float]) -> str:
    return "{" + ", ".join(f"{age:g}" for age in ages) + "}"
