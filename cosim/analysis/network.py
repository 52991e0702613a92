"""The channels of a scenario as one network, for the design that takes delay, jitter and loss."""

from __future__ import annotations

import math
from fractions import Fraction

from cosim.scenario import Direction, Scenario
from cosim.scenario.describe import average
from cosim.theory.chance.network import Network


def network_of(scenario: Scenario) -> Network | None:
    """The worst of each over all channels and directions; ``None`` where nothing crosses one."""
    used = {link.via for link in scenario.connections if link.via is not None}
    if not used:
        return None
    channels = [scenario.channels[name] for name in sorted(used)]
    ways = [
        _facts(way, scenario.base_rate)
        for channel in channels
        for way in (channel.forward, channel.backward)
    ]
    delays, jitters, losses = zip(*ways, strict=True)
    return Network(
        period=Fraction(max(channel.period for channel in channels)) / scenario.base_rate,
        delay=max(delays),
        jitter=max(jitters),
        loss=max(losses),
    )


def _facts(way: Direction, base_rate: Fraction) -> tuple[float, float, float]:
    """Mean delay (s), RMS jitter (s) and probability of loss of one direction."""
    tick = float(1 / base_rate)
    found = average(way)
    return found.delay * tick, math.sqrt(found.variance) * tick, found.lost
