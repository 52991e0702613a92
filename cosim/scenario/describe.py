"""What a scenario says about itself, as plain data for programs and for ``cohaptic check``."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from cosim.scenario.model import (
    Bernoulli,
    Channel,
    Component,
    Connection,
    Delay,
    Direction,
    Scenario,
)


def describe(scenario: Scenario) -> dict[str, Any]:
    """Rates, components, channels and connections as JSON-ready data (SI units, ticks)."""
    return {
        "scenario": str(scenario.file),
        "name": scenario.name,
        "title": scenario.title,
        "duration": number(scenario.duration),
        "ticks": scenario.ticks,
        "base_rate": number(scenario.base_rate),
        "seed": scenario.seed,
        "stations": list(scenario.stations),
        "rates": {
            name: {"rate": number(rate), "period": int(scenario.base_rate / rate)}
            for name, rate in scenario.rates.items()
        },
        "components": {name: _component(part) for name, part in scenario.components.items()},
        "channels": {name: _channel(channel) for name, channel in scenario.channels.items()},
        "connections": [_connection(connection) for connection in scenario.connections],
    }


def number(value: Fraction) -> float:
    """A fraction as a JSON number: an integer where it is one."""
    return value.numerator if value.denominator == 1 else float(value)


def _component(part: Component) -> dict[str, Any]:
    return {
        "kind": part.kind.value,
        "source": part.source,
        "station": part.station,
        "rate": number(part.rate),
        "period": part.period,
        "substeps": part.substeps,
        "feedthrough": part.feedthrough,
    }


def _channel(channel: Channel) -> dict[str, Any]:
    return {
        "between": list(channel.between),
        "rate": number(channel.rate),
        "period": channel.period,
        "forward": _direction(channel.forward),
        "backward": _direction(channel.backward),
    }


def _direction(way: Direction) -> dict[str, Any]:
    loss = way.loss
    if isinstance(loss, Bernoulli):
        mean = loss.probability
    else:
        bad = loss.good_to_bad / (loss.good_to_bad + loss.bad_to_good)
        mean = (1.0 - bad) * loss.loss_good + bad * loss.loss_bad
    if way.trace is not None:
        mean = sum(ticks < 0 for ticks in way.trace) / len(way.trace)
    return {
        "delay": _delay(way.delay),
        "jitter": (len(way.jitter.weights) - 1) * way.jitter.step,
        "loss": mean,
        "reorder": way.reorder.probability,
        "duplication": way.duplication.probability,
        "trace": None if way.trace is None else len(way.trace),
    }


def _delay(delay: Delay) -> dict[str, Any]:
    return {"ticks": delay.ticks, "samples": delay.samples}


def _connection(connection: Connection) -> dict[str, Any]:
    return {
        "from": str(connection.source),
        "to": str(connection.target),
        "via": connection.via,
        "rate": None if connection.rate is None else number(connection.rate),
        "delay": _delay(connection.delay),
    }
