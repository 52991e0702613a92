"""Delays that are longer than the run: nothing that is sent would ever arrive."""

from __future__ import annotations

from collections.abc import Iterator

from cosim.scenario import Scenario


def packets_that_come_too_late(scenario: Scenario) -> list[str]:
    """A sentence for every way and connection whose delay is at least as long as the run."""
    return [
        f"{where} delays values by {delay} ticks and the run ends after {scenario.ticks}: "
        "nothing arrives"
        for where, delay in _delays(scenario)
        if delay >= scenario.ticks
    ]


def _delays(scenario: Scenario) -> Iterator[tuple[str, int]]:
    for name, channel in scenario.channels.items():
        for way, direction in (("forward", channel.forward), ("backward", channel.backward)):
            yield f"the channel {name} ({way})", direction.delay.ticks
    for connection in scenario.connections:
        arrow = f"{connection.source} -> {connection.target}"
        yield f"the connection '{arrow}'", connection.delay.ticks
