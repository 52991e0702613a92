"""The chain of what links hold: which fate comes with which probability, period after period.

Of independent delays the age of what is held is a Markov chain: a packet of age b that is newer has
not arrived yet, and arrives o ticks into the period with probability P(d = bN + o) / P(d ≥ bN),
N ticks being the period. Bursts of losses are a chain of their own (Gilbert 1960, Elliott 1963).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from cosim.analysis.chance.delays import PacketDelays
from cosim.analysis.chance.fate import LOST, PeriodFate, on_time
from cosim.base.errors import InputError
from cosim.scenario.impairments.loss import GilbertElliott
from cosim.theory.chance.packets import Losses

MOST_STEPS = 20_000


@dataclass(frozen=True, slots=True)
class ChainStep:
    """One period: from mode to mode, with what every link's receiver gets in it."""

    source: int
    target: int
    probability: float
    fates: tuple[PeriodFate, ...]


@dataclass(frozen=True, slots=True)
class Chain:
    """What the network does, period after period.

    Attributes:
        modes: how many there are.
        steps: the probabilities of those from one mode sum to 1.
    """

    modes: int
    steps: tuple[ChainStep, ...]

    @property
    def outcomes(self) -> tuple[tuple[PeriodFate, ...], ...]:
        """Every combination of fates that happens, in a fixed order."""
        return tuple(sorted({step.fates for step in self.steps}))


def link_chain(packets: PacketDelays, *, aged: bool = False) -> Chain:
    """The chain of one link.

    Args:
        packets: what it does to each.
        aged: somebody reads how old the held packet is, so that fates differ by that too.
    """
    if len(packets.ticks) == 1:
        arrives = on_time(next(iter(packets.ticks)), packets.period)
        if not isinstance(packets.loss, GilbertElliott):
            return Chain(1, _merged(_lost_or(0, 0, packets.loss, 1.0, arrives)))
        bursts = packets.loss
        moves = (
            (0, 0, 1 - bursts.good_to_bad),
            (0, 1, bursts.good_to_bad),
            (1, 0, bursts.bad_to_good),
            (1, 1, 1 - bursts.bad_to_good),
        )
        losses = (bursts.loss_good, bursts.loss_bad)
        steps = [_lost_or(i, j, losses[j], chance, arrives) for i, j, chance in moves]
        return Chain(2, _merged(itertools.chain(*steps)))
    return _by_age(packets, aged=aged)


def _lost_or(
    source: int, target: int, loss: float, chance: float, arrives: PeriodFate
) -> list[ChainStep]:
    return [
        ChainStep(source, target, chance * (1.0 - loss), (arrives,)),
        ChainStep(source, target, chance * loss, (LOST,)),
    ]


def _by_age(packets: PacketDelays, *, aged: bool) -> Chain:
    """Mode m: what is held at a period's start is m + 1 periods old, or older at the last mode."""
    assert not isinstance(packets.loss, GilbertElliott)
    period, oldest = packets.period, packets.longest // packets.period
    chances = {ticks: (1.0 - packets.loss) * share for ticks, share in packets.ticks.items()}
    steps: list[ChainStep] = []
    for mode in range(oldest + 1):
        found: dict[tuple[tuple[int, int], ...], float] = {(): 1.0}
        for age in range(min(mode, oldest) + 1):
            left = packets.loss + sum(c for ticks, c in chances.items() if ticks >= age * period)
            if left <= 0.0:
                continue
            now = {o: chances.get(age * period + o, 0.0) / left for o in range(period)}
            found = _with(found, age, {o: share for o, share in now.items() if share > 0.0})
        for arrivals, chance in found.items():
            newest = arrivals[-1][1] if arrivals else mode + 1
            fate = PeriodFate(arrivals, mode + 1 if aged else 0)
            steps.append(ChainStep(mode, min(newest, oldest), chance, (fate,)))
    return Chain(oldest + 1, _merged(steps))


def _with(
    newer: dict[tuple[tuple[int, int], ...], float], age: int, now: dict[int, float]
) -> dict[tuple[tuple[int, int], ...], float]:
    """Arrivals with one more packet, which is of no account once a newer one is there."""
    found: dict[tuple[tuple[int, int], ...], float] = {}
    for arrivals, chance in newer.items():
        first = arrivals[0][0] if arrivals else None
        rest = chance
        for offset, share in now.items():
            if first is None or offset < first:
                key = ((offset, age), *arrivals)
                found[key] = found.get(key, 0.0) + chance * share
                rest -= chance * share
        if rest > 1e-15:
            found[arrivals] = found.get(arrivals, 0.0) + rest
    return found


def side_by_side(chains: Sequence[Chain]) -> Chain:
    """Links that are each by itself.

    Raises:
        InputError: there are too many combinations.
    """
    modes, steps = 1, [ChainStep(0, 0, 1.0, ())]
    for chain in chains:
        if len(steps) * len(chain.steps) > MOST_STEPS:
            raise InputError(
                f"The delays and losses of {len(chains)} directions have more than {MOST_STEPS} "
                "combinations: give jitter whole samples, or ask with --losses together."
            )
        steps = [
            ChainStep(
                one.source * chain.modes + two.source,
                one.target * chain.modes + two.target,
                one.probability * two.probability,
                one.fates + two.fates,
            )
            for one in steps
            for two in chain.steps
        ]
        modes *= chain.modes
    return Chain(modes, tuple(steps))


def all_together(links: Sequence[PacketDelays]) -> Chain:
    """Links that lose their packets together, the first saying when.

    Raises:
        InputError: their delays vary, which they do each by itself.
    """
    if any(len(link.ticks) > 1 for link in links):
        raise InputError(
            "Packets that are each late by their own time are not lost together: ask with "
            "--losses independent."
        )
    chain = link_chain(links[0])
    arrive = tuple(on_time(next(iter(link.ticks)), link.period) for link in links)
    lost = (LOST,) * len(links)
    return Chain(
        chain.modes,
        tuple(
            ChainStep(s.source, s.target, s.probability, lost if s.fates == (LOST,) else arrive)
            for s in chain.steps
        ),
    )


def chain_of(links: Sequence[PacketDelays], losses: Losses, *, aged: bool = False) -> Chain:
    """The chain of all links."""
    if losses == "together":
        return all_together(links)
    return side_by_side([link_chain(link, aged=aged) for link in links])


def _merged(steps: itertools.chain[ChainStep] | Sequence[ChainStep]) -> tuple[ChainStep, ...]:
    """Steps that happen, alike ones as one."""
    found: dict[tuple[int, int, tuple[PeriodFate, ...]], float] = {}
    for step in steps:
        key = step.source, step.target, step.fates
        found[key] = found.get(key, 0.0) + step.probability
    return tuple(
        ChainStep(i, j, chance, fates) for (i, j, fates), chance in found.items() if chance
    )
