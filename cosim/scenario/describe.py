"""What a scenario says about itself, as plain data for programs and for ``cohaptic check``."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from cosim.scenario.impairments.effect import Average
from cosim.scenario.impairments.registry import impairments
from cosim.scenario.model import (
    Channel,
    Connection,
    Delay,
    Direction,
    Scenario,
    ScenarioComponent,
)


def describe(scenario: Scenario) -> dict[str, Any]:
    """Rates, components, channels and connections as JSON-ready data (SI units, ticks)."""
    return {
        "scenario": str(scenario.file),
        "name": scenario.name,
        "title": scenario.title,
        "duration": number(scenario.duration),
        "start_time": number(scenario.start_time),
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
        "knobs": [str(knob.target) for knob in scenario.knobs],
        "events": [
            {"tick": event.tick, "target": str(event.target), "value": event.value}
            for event in scenario.events
        ],
    }


def number(value: Fraction) -> float:
    """A fraction as a JSON number: an integer where it is one."""
    return value.numerator if value.denominator == 1 else float(value)


def _component(part: ScenarioComponent) -> dict[str, Any]:
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
    effects = {name: way.impairments.get(name) for name in impairments()}
    values = {
        name: impairments()[name].absent if effect is None else effect.describe()
        for name, effect in effects.items()
    }
    sentences = [effect.sentence() for effect in effects.values() if effect is not None]
    replaced = any(impairments()[name].replaces for name in way.impairments)
    return {
        "delay": _delay(way.delay),
        **values,
        "lost": average(way).lost,
        "sentence": ", ".join(sentences if replaced else [_delay_sentence(way.delay), *sentences]),
    }


def average(way: Direction) -> Average:
    """Mean and variance (ticks) of the delay of one direction, and how much of it is lost."""
    found = Average(float(way.delay.ticks), 0.0, 0.0)
    for effect in sorted(way.impairments.values(), key=lambda effect: effect.order):
        found = effect.average(found)
    return found


def _delay_sentence(delay: Delay) -> str:
    ticks = f"delay {delay.ticks} tick{'' if delay.ticks == 1 else 's'}"
    if not delay.samples:
        return ticks
    return f"{ticks} ({delay.samples} sample{'s' if delay.samples > 1 else ''})"


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
