"""What an adversary may do to packets: delays that switch in a set, losses in bounded bursts."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.chance.mean_square import jump_system
from cosim.theory.chance.packets import LinkProcess, Losses, Pattern, bernoulli, join
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import FrameAssembly
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import LONGEST_DELAY, Timing
from cosim.theory.robust.automaton import Automaton, Edge, arbitrary

MOST_MAPS = 256
"""Of an automaton: every one of them is a matrix inequality."""


def switching_delays(
    model: Model,
    timing: Timing,
    forward: Sequence[int],
    backward: Sequence[int],
    *,
    freshest: bool = False,
) -> tuple[Automaton, tuple[tuple[int, ...], ...]]:
    """Every link holds in every frame a packet of any age of its direction's set.

    Args:
        model: the loop.
        timing: rates; its own delay is of no account.
        forward: ages in network samples that packets of the first direction may have.
        backward: those of the other direction.
        freshest: a receiver never goes back to an older packet, so that an age grows by one
            sample a frame at most. Otherwise any age may follow any other.

    Returns:
        The automaton, and per map the age on every link.

    Raises:
        InputError: a set is empty, an age is negative or too long, there are too many
            combinations, or nothing crosses the network.
    """
    for ages in (forward, backward):
        if not ages or min(ages) < 0 or max(ages) > LONGEST_DELAY:
            raise InputError(
                "A set of delays holds at least one, in network samples from 0 to "
                f"{LONGEST_DELAY}: {', '.join(map(str, ages)) or 'this one is empty'}."
            )
    assembly = _linked(model, timing)
    sets = [
        tuple(sorted(set(forward if link.source < link.target else backward)))
        for link in assembly.links
    ]
    refuse_many(int(np.prod([len(ages) for ages in sets])))
    outcomes = tuple(itertools.product(*sets))
    count = len(outcomes)
    pattern = Pattern(
        np.ones((1, 1)),
        np.full((1, count), 1.0 / count),
        outcomes,
        tuple(max(ages) for ages in sets),
    )
    maps = jump_system(assembly, pattern, grounded=model.grounded).maps
    if not freshest:
        return arbitrary(maps), outcomes
    edges = [
        Edge(before, after, after)
        for before, old in enumerate(outcomes)
        for after, new in enumerate(outcomes)
        if all(age <= last + 1 for age, last in zip(new, old, strict=True))
    ]
    refuse_many(len(edges))
    return Automaton(maps, tuple(edges), count), outcomes


def bounded_bursts(
    model: Model, timing: Timing, longest: int, losses: Losses = "independent"
) -> tuple[Automaton, tuple[tuple[int, ...], ...]]:
    """At most ``longest`` packets in a row are lost on every link; nothing else is known.

    Args:
        model: the loop.
        timing: rates and the fixed delay.
        longest: packets.
        losses: every link by itself, or all together.

    Returns:
        The automaton, a node for the losses so far of every link; and per map the event on every
        link, the age that arrives or ``HOLD``.

    Raises:
        InputError: nothing crosses the network, or there are too many combinations.
    """
    assembly = _linked(model, timing)
    processes: list[LinkProcess] = [bernoulli(0.5, link.delay) for link in assembly.links]
    chains = 1 if losses == "together" else len(processes)
    refuse_many((2 * (longest + 1)) ** chains)
    pattern = join(processes, losses)
    maps = jump_system(assembly, pattern, grounded=model.grounded).maps
    states = list(itertools.product(range(longest + 1), repeat=chains))
    number = {state: place for place, state in enumerate(states)}
    edges: list[Edge] = []
    for place, outcome in enumerate(pattern.outcomes):
        lost = [event < 0 for event in outcome][:chains]
        for state in states:
            after = tuple(c + 1 if gone else 0 for c, gone in zip(state, lost, strict=True))
            if max(after) <= longest:
                edges.append(Edge(number[state], number[after], place))
    return Automaton(maps, tuple(edges), len(states)), pattern.outcomes


def _linked(model: Model, timing: Timing) -> FrameAssembly:
    assembly = assemble(model, timing)
    if not assembly.links:
        raise InputError("Nothing crosses a network in this loop, so that nothing is late or lost.")
    return assembly


def refuse_many(count: int) -> None:
    """Whether so many matrix inequalities are solved for.

    Raises:
        InputError: they are too many.
    """
    if count > MOST_MAPS:
        raise InputError(
            f"These combinations are {count} matrix inequalities; up to {MOST_MAPS} are solved "
            "for. Take fewer delays, shorter bursts or fewer users, or losses together."
        )
