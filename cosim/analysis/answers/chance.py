"""A run whose packets are lost or late by chance: one map for every fate, and second moments.

A lost packet is taken away at the start of the period in which it is due. A late one is one that
its receiver takes later: the channel then holds as many packets as the longest delay, and each fate
says which of them is taken. With maps M_e the loop is mean-square stable exactly where the spectral
radius of X → Σ p_e M_e X M_eᵀ is below 1 (Costa, Fragoso and Marques 2005, theorem 3.9).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.blocks import connected_blocks, dropped
from cosim.analysis.monodromy.jacobian import jacobian
from cosim.analysis.monodromy.neutral import quotient
from cosim.analysis.monodromy.point import Point
from cosim.analysis.monodromy.run_map import LOST
from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.scenario.impairments.effect import Effect
from cosim.scenario.impairments.loss import Bernoulli, GilbertElliott
from cosim.theory.chance.packets import LinkProcess as Process
from cosim.theory.chance.packets import Losses, Pattern, bernoulli, join
from cosim.theory.numerics import find_root, largest_eigenvalue_of_map, spectral_radius

Real = NDArray[np.float64]

MOST_OUTCOMES = 64
DENSE = 150
"""Up to so many second moments their map is formed."""
HIGHEST = 0.999
"""Where the search for the critical loss ends."""


@dataclass(frozen=True, slots=True)
class FateMaps:
    """The map of every fate of the links' packets.

    Attributes:
        links: what each link carries, ``channel.direction`` and its stations.
        outcomes: per map, which links lose their packet.
        blocks: per strongly connected block, the maps on its quotient, shape (outcomes, m, m).
    """

    links: tuple[str, ...]
    outcomes: tuple[tuple[bool, ...], ...]
    blocks: tuple[Real, ...]

    def mean_square_radius(self, pattern: Pattern, order: Sequence[int]) -> float:
        """ρ of the second moments under a pattern; ``order`` finds each outcome's map."""
        return max(
            (_radius(maps[list(order)], pattern) for maps in self.blocks),
            default=0.0,
        )


def fate_maps(point: Point, losses: Losses = "independent") -> FateMaps:
    """The derivative of Φ for every combination of lost packets.

    Args:
        point: a run whose hyperperiod is its network period.
        losses: whether directions lose their packets each by itself or all together.

    Raises:
        InputError: nothing crosses a channel, rates do not fit, or there are too many directions.
    """
    run = point.run
    numbers = [b.number for b in run.bundles if b.bundle.channel is not None]
    links = tuple(run.bundles[number].bundle.name for number in numbers)
    if not numbers:
        raise InputError("Nothing crosses a channel, so that there are no packets to lose.")
    if any(run.bundles[number].bundle.period != run.hyperperiod for number in numbers):
        raise InputError(
            "Loss is asked for where every channel sends once in the hyperperiod: give the "
            "channels one rate that divides the control rate."
        )
    if losses == "together":
        outcomes: tuple[tuple[bool, ...], ...] = ((False,) * len(links), (True,) * len(links))
    else:
        outcomes = tuple(itertools.product((False, True), repeat=len(links)))
    if len(outcomes) > MOST_OUTCOMES:
        raise InputError(
            f"{len(links)} directions that lose packets independently make {len(outcomes)} maps: "
            "ask with --losses together."
        )
    maps = [point.matrix]
    for outcome in outcomes[1:]:
        lost = {n: LOST for n, gone in zip(numbers, outcome, strict=True) if gone}
        maps.append(jacobian(run, fates=lost))
    return FateMaps(links, outcomes, _blocks(point, maps))


def _blocks(point: Point, maps: list[Real]) -> tuple[Real, ...]:
    run = point.run
    kept = ~dropped(maps)
    found: list[Real] = []
    for block in connected_blocks(maps, kept):
        size = run.steps[block]
        inner = [one[np.ix_(block, block)] * size[None, :] / size[:, None] for one in maps]
        if block.size == 1 and (
            not any(one.any() for one in inner) or all(one[0, 0] == 1.0 for one in inner)
        ):
            continue
        units = [run.coordinates[number].unit for number in map(int, block)]
        if run.is_linear:
            inner = [one[np.ix_(block, block)] for one in maps]
        found.append(np.array(quotient(inner, units, is_linear=run.is_linear).maps))
    return tuple(found)


def _radius(maps: Real, pattern: Pattern) -> float:
    modes, size = pattern.transition.shape[0], maps.shape[1]
    weights = pattern.emission

    def apply(vector: Real) -> Real:
        moments = np.asarray(vector).reshape(modes, size, size)
        mixed = np.einsum("ij,iab->jab", pattern.transition, moments)
        moved = np.zeros_like(mixed)
        for outcome, one in enumerate(maps):
            for mode in range(modes):
                if weights[mode, outcome]:
                    moved[mode] += weights[mode, outcome] * (one @ mixed[mode] @ one.T)
        return moved.reshape(-1)

    start = np.tile(np.eye(size).reshape(-1), modes)
    if start.size <= DENSE:
        return spectral_radius(np.array([apply(column) for column in np.eye(start.size)]).T)
    return largest_eigenvalue_of_map(apply, start, accuracy=1e-7)


def mean_square_at(
    maps: FateMaps, process: Callable[[int], Process], losses: Losses = "independent"
) -> float:
    """The mean-square radius where every direction behaves alike."""
    return mean_square_of(maps, [process(0) for _ in maps.links], losses)


def mean_square_of(maps: FateMaps, processes: Sequence[Process], losses: Losses) -> float:
    """The mean-square radius where each direction has its own losses."""
    pattern = join(processes, losses)
    place = {outcome: number for number, outcome in enumerate(maps.outcomes)}
    order = [place[tuple(event < 0 for event in outcome)] for outcome in pattern.outcomes]
    return maps.mean_square_radius(pattern, order)


def critical_run_loss(maps: FateMaps, losses: Losses = "independent") -> float | None:
    """The smallest loss at which the run is no longer mean-square stable; None up to 0.999."""

    def radius(loss: float) -> float:
        return mean_square_at(maps, lambda delay: bernoulli(loss, delay), losses)

    if radius(0.0) >= 1.0 - 1e-12:
        return 0.0
    stable = 0.0
    for loss in (*np.linspace(0.1, 0.9, 9), 0.99, HIGHEST):
        if radius(float(loss)) >= 1.0:
            return find_root(lambda p: math.log(radius(p)), stable, float(loss), 1e-6)
        stable = float(loss)
    return None


def own_processes(scenario: Scenario, links: Sequence[str]) -> list[Process] | None:
    """What the scenario's own channels do to each direction's packets; None where that is nothing.

    Raises:
        InputError: something else than loss and duplication, which is of no consequence.
    """
    found: list[Process] = []
    for link in links:
        name, way = link.rsplit(".", 1)
        channel = scenario.channels[name]
        effects = (channel.forward if way == "forward" else channel.backward).impairments
        others = sorted(effects.keys() - {"loss", "duplication"})
        if others:
            raise InputError(
                f"{link} has {' and '.join(others)}, of which the theory of a run knows nothing: "
                "ask without, or take 'cohaptic theory design', which knows a network's jitter.",
                scenario.locate(("channels", name)),
            )
        found.append(_process(effects.get("loss")))
    if all(process.transition.shape == (1, 1) and process.emission[0, 1] == 0 for process in found):
        return None
    return found


def _process(effect: Effect | None) -> Process:
    if effect is None:
        return bernoulli(0.0, 0)
    if isinstance(effect, Bernoulli):
        return bernoulli(effect.probability, 0)
    assert isinstance(effect, GilbertElliott)
    transition = np.array(
        [
            [1 - effect.good_to_bad, effect.good_to_bad],
            [effect.bad_to_good, 1 - effect.bad_to_good],
        ]
    )
    emission = np.array(
        [[1 - effect.loss_good, effect.loss_good], [1 - effect.loss_bad, effect.loss_bad]]
    )
    return Process(transition, emission, (0, LOST))
