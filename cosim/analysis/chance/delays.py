"""What a direction of a channel does to a packet: the probability of each delay, and its losses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cosim.base.errors import InputError
from cosim.scenario import Direction, Scenario
from cosim.scenario.impairments.jitter import Jitter
from cosim.scenario.impairments.loss import Bernoulli, GilbertElliott
from cosim.scenario.impairments.reorder import Reorder

HARMLESS = frozenset({"duplication"})
"""Receivers drop second copies."""
_INDEPENDENT = HARMLESS | {"jitter", "reorder", "loss"}


@dataclass(frozen=True, slots=True)
class PacketDelays:
    """One direction's packets; every packet draws for itself, bursts of losses apart.

    Attributes:
        ticks: the probability of each delay (base ticks) of a packet that is not lost; sums to 1.
        period: base ticks from one packet to the next.
        loss: of each packet by itself, or a chain of bursts.
    """

    ticks: Mapping[int, float]
    period: int
    loss: float | GilbertElliott = 0.0

    @property
    def longest(self) -> int:
        """Ticks."""
        return max(self.ticks)

    @property
    def is_certain(self) -> bool:
        """Whether every packet arrives after the same time."""
        return len(self.ticks) == 1 and self.loss == 0.0

    def losing(self, loss: float | GilbertElliott) -> PacketDelays:
        """The same delays with other losses."""
        return replace(self, loss=loss)


def packet_delays(direction: Direction, period: int) -> PacketDelays | None:
    """What a direction does to each packet; None where packets follow something recorded."""
    if not direction.impairments.keys() <= _INDEPENDENT:
        return None
    ticks = {direction.delay.ticks: 1.0}
    loss: float | GilbertElliott = 0.0
    for effect in direction.impairments.values():
        if isinstance(effect, Jitter):
            ticks = _later(ticks, {n * effect.step: w for n, w in enumerate(effect.weights)})
        elif isinstance(effect, Reorder):
            chance = effect.late.probability
            ticks = _later(ticks, {0: 1.0 - chance, effect.late.ticks: chance})
        elif isinstance(effect, Bernoulli):
            loss = effect.probability
        elif isinstance(effect, GilbertElliott):
            loss = _in_the_long_run(effect)
    return PacketDelays(ticks, period, loss)


def _in_the_long_run(bursts: GilbertElliott) -> float | GilbertElliott:
    """Bursts that never begin, or never end, are the losses of the one state that there is."""
    if bursts.good_to_bad == 0.0:
        return bursts.loss_good
    return bursts.loss_bad if bursts.bad_to_good == 0.0 else bursts


def link_delays(scenario: Scenario, link: str) -> PacketDelays:
    """The same of ``channel.direction``.

    Raises:
        InputError: its packets do not draw by themselves, by name.
    """
    name, way = link.rsplit(".", 1)
    channel = scenario.channels[name]
    direction = channel.forward if way == "forward" else channel.backward
    found = packet_delays(direction, channel.period)
    place = scenario.locate(("channels", name))
    if found is None:
        others = sorted(direction.impairments.keys() - _INDEPENDENT)
        raise InputError(
            f"{link} has {' and '.join(others)}, of which the theory of a run knows nothing: ask "
            "without, or write the delays as jitter, with a weight for each.",
            place,
        )
    if isinstance(found.loss, GilbertElliott) and len(found.ticks) > 1:
        raise InputError(
            f"{link} loses packets in bursts and delays each by its own time: the theory of a run "
            "knows bursts at one delay, and delays with losses that come each by itself. Ask with "
            f"the average loss, --set channels.{name}.loss={found.loss.share:.4g}.",
            place,
        )
    return found


def _later(ticks: Mapping[int, float], by: Mapping[int, float]) -> dict[int, float]:
    found: dict[int, float] = {}
    for one, chance in ticks.items():
        for other, share in by.items():
            if chance * share > 0.0:
                found[one + other] = found.get(one + other, 0.0) + chance * share
    return found
