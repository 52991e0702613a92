"""Whatever comes to a run's packets: delays in any order, losses in any bursts of bounded length.

The maps are those of the fates of chance; here an adversary chooses among them. Receivers keep the
newest packet, so that what may come depends on the age of what is held: an automaton, whose nodes
are the modes of the chain, or how many packets are missing.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.chance import with_losses
from cosim.analysis.chance.chain import Chain, chain_of
from cosim.analysis.chance.delays import PacketDelays, link_delays
from cosim.analysis.chance.fate import PeriodFate, on_time
from cosim.analysis.chance.fate_maps import FateMaps, fate_maps, links_of
from cosim.analysis.monodromy.point import Point
from cosim.analysis.monodromy.saved_bundle import reads_ages
from cosim.base.errors import InputError
from cosim.theory.chance.packets import Losses
from cosim.theory.models.timing import LONGEST_DELAY
from cosim.theory.numerics import spectral_radius
from cosim.theory.robust.automaton import Automaton, Edge
from cosim.theory.robust.joint_radius import JointRadius, joint_radius
from cosim.theory.robust.network import refuse_many

Real = NDArray[np.float64]

PUSHED = 0.03
"""How far the run is pushed to see it grow, in steps of its differences."""
MOST_FOLLOWED = 240
"""Periods for which a run is followed."""
FURTHEST = 30.0
"""Times the push: as far as it may grow before something switches."""


@dataclass(frozen=True, slots=True)
class RunOrders:
    """What may come to the packets of a run.

    Attributes:
        point: where it stands; closed by whoever asked.
        links: ``channel.direction``.
        maps: of every outcome that may come.
        edges: which may follow which.
        nodes: how many there are.
        ticks: per link, the delays that its packets may have.
    """

    point: Point
    links: tuple[str, ...]
    maps: FateMaps
    edges: tuple[Edge, ...]
    nodes: int
    ticks: tuple[tuple[int, ...], ...]

    def joint_radius(self) -> JointRadius:
        """Bounds per network period: the largest of the connected blocks'."""
        found = [
            joint_radius(Automaton(block, self.edges, self.nodes)) for block in self.maps.blocks
        ]
        if not found:
            raise InputError("Nothing in this run depends on its past.")
        worst = max(found, key=lambda one: one.lower)
        return JointRadius(
            worst.lower,
            max(one.upper for one in found),
            max(one.quadratic for one in found),
            worst.word,
            worst.depth,
        )

    def fixed(self) -> dict[tuple[int, ...], float]:
        """The spectral radius with delays that stay, by the delay of every link (ticks)."""
        period = self.point.run.hyperperiod
        place = {outcome: number for number, outcome in enumerate(self.maps.outcomes)}
        found: dict[tuple[int, ...], float] = {}
        for delays in itertools.product(*self.ticks):
            plain = tuple(on_time(delay, period) for delay in delays)
            aged = tuple(PeriodFate(one.arrivals, one.arrivals[0][1] + 1) for one in plain)
            number = place.get(plain, place.get(aged))
            if number is not None:
                found[delays] = max(spectral_radius(block[number]) for block in self.maps.blocks)
        return found

    def kernel_growth(self, word: Sequence[int]) -> float:
        """The growth per period that the real kernel shows when a word is repeated.

        The run is pushed both ways along the slowest motion of the word's product and followed with
        packets that meet these fates; the difference of both is what grows.
        """
        run = self.point.run
        numbers = [b.number for b in run.bundles if b.bundle.channel is not None]
        product = np.eye(run.size)
        for number in word:
            product = self.maps.maps[number] @ product
        shape = _slowest(product, run.steps)
        expected = max(abs(_fitted([product @ (product @ shape), product @ shape, shape])), 1e-3)
        rounds = max(3, min(MOST_FOLLOWED // len(word), int(_within(expected))))
        run.undisturbed()
        pushed, left = run.start + PUSHED * shape, run.start - PUSHED * shape
        seen = [pushed - left]
        for _ in range(rounds):
            for number in word:
                fates = dict(zip(numbers, self.maps.outcomes[number], strict=True))
                pushed, left = run.follow(pushed, fates), run.follow(left, fates)
            seen.insert(0, pushed - left)
        scaled = [one / run.steps for one in seen]
        return float(abs(_fitted(scaled)) ** (1.0 / len(word)))


def _within(growth: float) -> float:
    if abs(np.log(growth)) < 1e-6:
        return MOST_FOLLOWED
    return max(3.0, np.log(FURTHEST) / abs(np.log(growth)))


def _slowest(product: Real, steps: Real) -> Real:
    """The real part of the eigenvector that grows most, its largest entry one step."""
    scaled = product * steps[None, :] / steps[:, None]
    values, vectors = np.linalg.eig(scaled)
    off = np.abs(values - 1.0) > 1e-9
    best = int(np.argmax(np.where(off, np.abs(values), 0.0)))
    shape = np.real(vectors[:, best])
    return np.asarray(shape / np.abs(shape).max() * steps)


def _fitted(seen: Sequence[Real]) -> complex:
    """The eigenvalue that a motion shows, newest first: of x″ = a x′ + b x, or of x′ = a x."""
    rows = np.array(seen)[::-1]
    after, now, before = (rows[n : len(rows) - 2 + n].reshape(-1) for n in (2, 1, 0))
    (a, b), *_ = np.linalg.lstsq(np.column_stack([now, before]), after, rcond=1e-9)
    return max(np.roots([1.0, -a, -b]).astype(np.complex128), key=abs)


def switching_run(
    asked: AskedRun, forward: Sequence[int] | None, backward: Sequence[int] | None
) -> RunOrders:
    """A run whose packets take any delay of a set, each as an adversary likes.

    Args:
        asked: the run.
        forward: whole network samples, for every channel's first direction; None: what the
            channel's jitter may make of it, or, where that is nothing, its delay and one sample
            more.
        backward: the same of the other direction.

    Raises:
        InputError: packets are lost, or there are too many combinations.
    """
    scenario = asked.scenario
    _refuse_losses(asked)
    sets: list[str] = []
    for name in scenario.channels:
        jitter: list[str] = []
        shortest: list[str] = []
        for way, ages in (("forward", forward), ("backward", backward)):
            own = link_delays(scenario, f"{name}.{way}")
            ticks = _ticks(own, ages)
            shortest.append(f"{way}: {ticks[0]} ticks")
            weights = [1.0 if ticks[0] + more in ticks else 0.0 for more in range(_span(ticks) + 1)]
            shares = [weight / len(ticks) for weight in weights]
            if len(shares) > 1:
                jitter.append(f"{way}: {{weights: {shares}, step: 1 tick}}")
        sets += [
            f"channels.{name}.{form}=~"
            for form in ("round_trip_delay", "each_way_delay", "reorder", "jitter")
        ]
        sets.append(f"channels.{name}.delay={{{', '.join(shortest)}}}")
        if jitter:
            sets.append(f"channels.{name}.jitter={{{', '.join(jitter)}}}")
    point = asked.fresh(sets)
    try:
        links = links_of(point)
        packets = [link_delays(point.run.simulation.scenario, link) for link in links]
        aged = reads_ages(point.run.simulation)
        chain = chain_of(packets, "independent", aged=aged)
        refuse_many(len(chain.steps))
        return _orders(point, links, packets, fate_maps(point, chain), chain)
    except BaseException:
        point.close()
        raise


def _orders(
    point: Point,
    links: tuple[str, ...],
    packets: Sequence[PacketDelays],
    maps: FateMaps,
    chain: Chain,
) -> RunOrders:
    place = {outcome: number for number, outcome in enumerate(maps.outcomes)}
    found = {(s.source, s.target, place[s.fates]) for s in chain.steps if s.probability > 0.0}
    edges = tuple(Edge(*one) for one in sorted(found))
    ticks = tuple(tuple(sorted(one.ticks)) for one in packets)
    return RunOrders(point, links, maps, edges, chain.modes, ticks)


def _ticks(own: PacketDelays, ages: Sequence[int] | None) -> list[int]:
    if ages is None:
        found = sorted(own.ticks)
        return found if len(found) > 1 else [found[0], found[0] + own.period]
    if not ages or min(ages) < 0 or max(ages) > LONGEST_DELAY:
        raise InputError(
            "A set of delays holds at least one, in network samples from 0 to "
            f"{LONGEST_DELAY}: {', '.join(map(str, ages)) or 'this one is empty'}."
        )
    return sorted({age * own.period for age in ages})


def _span(ticks: Sequence[int]) -> int:
    return ticks[-1] - ticks[0]


def _refuse_losses(asked: AskedRun) -> None:
    scenario = asked.scenario
    used = {link.via for link in scenario.connections if link.via is not None}
    for name in sorted(used):
        for way in ("forward", "backward"):
            if link_delays(scenario, f"{name}.{way}").loss != 0.0:
                raise InputError(
                    f"{name}.{way} loses packets, and delays that switch are of packets that come: "
                    f"ask without, --set channels.{name}.loss=~, or 'theory robust bursts'.",
                    scenario.locate(("channels", name)),
                )


def bursts_run(asked: AskedRun, longest: int, losses: Losses) -> RunOrders:
    """A run of which at most ``longest`` packets in a row are lost on every link.

    Args:
        asked: the run; its channels' own losses are left aside.
        longest: packets.
        losses: every link by itself, or all together.

    Raises:
        InputError: delays vary, something predicts from ages, or there are too many combinations.
    """
    point = asked.point()
    links = links_of(point)
    for link in links:
        if len(link_delays(asked.scenario, link).ticks) > 1:
            raise InputError(
                f"{link} has jitter, and bursts of lost packets are of one delay: ask without, "
                f"--set channels.{link.rsplit('.', 1)[0]}.jitter=~, or 'theory robust switching'.",
                asked.scenario.locate(("channels", link.rsplit(".", 1)[0])),
            )
    chains = 1 if losses == "together" else len(links)
    refuse_many((2 * (longest + 1)) ** chains)
    maps = with_losses(point, losses).maps
    states = list(itertools.product(range(longest + 1), repeat=chains))
    ticks = tuple(tuple(link_delays(asked.scenario, link).ticks) for link in links)
    return RunOrders(point, links, maps, _bounded(maps, states, longest), len(states), ticks)


def _bounded(maps: FateMaps, states: list[tuple[int, ...]], longest: int) -> tuple[Edge, ...]:
    number: Mapping[tuple[int, ...], int] = {state: place for place, state in enumerate(states)}
    edges: list[Edge] = []
    for place, outcome in enumerate(maps.outcomes):
        lost = [not fate.arrivals for fate in outcome][: len(states[0])]
        for state in states:
            after = tuple(c + 1 if gone else 0 for c, gone in zip(state, lost, strict=True))
            if max(after) <= longest:
                edges.append(Edge(number[state], number[after], place))
    return tuple(edges)
