"""The channels of a scenario as one network, for the design that takes delay, jitter and loss."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from cosim.scenario import Bernoulli, Direction, Scenario
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
    if way.trace is not None:
        fates = np.array(way.trace, dtype=np.float64)
        came = fates[fates >= 0.0]
        if not len(came):
            return 0.0, 0.0, 1.0
        return float(came.mean()) * tick, float(came.std()) * tick, 1.0 - len(came) / len(fates)
    extra = np.arange(len(way.jitter.weights)) * way.jitter.step
    weights = np.array(way.jitter.weights)
    mean = float(extra @ weights)
    spread = float(np.sqrt((extra - mean) ** 2 @ weights))
    loss = way.loss
    if isinstance(loss, Bernoulli):
        lost = loss.probability
    else:
        moves = loss.good_to_bad + loss.bad_to_good
        bad = loss.good_to_bad / moves if moves > 0.0 else 0.0
        lost = bad * loss.loss_bad + (1.0 - bad) * loss.loss_good
    return (way.delay.ticks + mean) * tick, spread * tick, lost
