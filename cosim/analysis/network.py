"""The channels of a scenario as one network, for the design that takes delay, jitter and loss."""

from __future__ import annotations

import math
from fractions import Fraction

from cosim.analysis.chance.delays import link_delays
from cosim.base.errors import InputError
from cosim.scenario import Direction, Scenario
from cosim.scenario.describe import average
from cosim.scenario.impairments.loss import GilbertElliott
from cosim.theory.chance.network import Network


def network_of(scenario: Scenario) -> Network | None:
    """The worst of each over all channels and directions; ``None`` where nothing crosses one.

    Raises:
        InputError: packets are lost in bursts or follow a trace, which a design does not know.
    """
    used = {link.via for link in scenario.connections if link.via is not None}
    if not used:
        return None
    channels = [scenario.channels[name] for name in sorted(used)]
    ways = [
        _facts(scenario, f"{channel.name}.{name}", way)
        for channel in channels
        for name, way in (("forward", channel.forward), ("backward", channel.backward))
    ]
    delays, jitters, losses = zip(*ways, strict=True)
    return Network(
        period=Fraction(max(channel.period for channel in channels)) / scenario.base_rate,
        delay=max(delays),
        jitter=max(jitters),
        loss=max(losses),
    )


def _facts(scenario: Scenario, link: str, way: Direction) -> tuple[float, float, float]:
    """Mean delay (s), RMS jitter (s) and probability of loss of one direction.

    What is held back counts as lost: the next packet has come already.
    """
    if isinstance(link_delays(scenario, link).loss, GilbertElliott):
        raise InputError(
            f"{link} loses packets in bursts, and a design stands losses that come each by itself: "
            "give their probability with --loss over a scenario without, and ask the result with "
            "'cohaptic theory radius --with'.",
            scenario.locate(("channels", link.partition(".")[0])),
        )
    tick = float(1 / scenario.base_rate)
    found = average(way)
    held_back = way.impairments.get("reorder")
    kept = 1.0 if held_back is None else 1.0 - held_back.describe()
    lost = 1.0 - (1.0 - found.lost) * kept
    return found.delay * tick, math.sqrt(found.variance) * tick, lost
