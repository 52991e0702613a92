"""A loaded scenario written out again as one self-contained YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, cast

from cosim.base.quantity import format_exact
from cosim.base.yaml_writer import write_yaml
from cosim.scenario.model import (
    Bernoulli,
    Channel,
    Component,
    Connection,
    Delay,
    Direction,
    Duplication,
    Jitter,
    Kind,
    Record,
    Reorder,
    Scenario,
)


def to_yaml(scenario: Scenario) -> str:
    """The whole scenario as YAML: one file with every default, include and override in it.

    Loading it again gives the same scenario.
    """
    return write_yaml(to_document(scenario))


def to_document(scenario: Scenario) -> dict[str, Any]:
    """The scenario in its written form, as plain data."""
    document: dict[str, Any] = {
        "cohaptic": scenario.cohaptic,
        "name": scenario.name,
        "title": scenario.title,
        "description": scenario.description,
        "duration": _exact(scenario.duration),
        "seed": scenario.seed,
        "base_rate": _exact(scenario.base_rate),
        "rates": {name: _exact(rate) for name, rate in scenario.rates.items()},
        "components": {name: _component(part) for name, part in scenario.components.items()},
        "channels": {name: _channel(channel) for name, channel in scenario.channels.items()},
        "connections": [_connection(connection) for connection in scenario.connections],
        "record": [_record(record) for record in scenario.record],
        "expect": _plain(scenario.expect),
        "safety": _plain(scenario.safety),
        "realtime": _plain(scenario.realtime),
        "link": _plain(scenario.link),
    }
    return document


def _component(part: Component) -> dict[str, Any]:
    source: Any = part.source
    if part.kind is Kind.DEVICE and part.options:
        source = {"url": part.source, **_plain(part.options)}
    written: dict[str, Any] = {part.kind.value: source}
    if part.kind is Kind.PLAYBACK:
        written["of"] = part.options["component"]
    written |= {"station": part.station, "rate": part.rate_name or _exact(part.rate)}
    if part.kind is Kind.FMU:
        if part.is_bundled:
            written["flavour"] = part.flavour
        written |= {"substeps": part.substeps, "feedthrough": part.feedthrough}
    if part.parameters:
        written["parameters"] = _plain(part.parameters)
    if part.start:
        written["start"] = _plain(part.start)
    return written


def _channel(channel: Channel) -> dict[str, Any]:
    ways = {"forward": channel.forward, "backward": channel.backward}
    written: dict[str, Any] = {
        "between": list(channel.between),
        "rate": channel.rate_name or _exact(channel.rate),
    }
    if all(way.trace is None for way in ways.values()):
        written["delay"] = {name: _delay(way.delay) for name, way in ways.items()}
        written["jitter"] = {name: _jitter(way.jitter, channel) for name, way in ways.items()}
        written["loss"] = {name: _loss(way) for name, way in ways.items()}
    else:
        written["trace"] = {n: _trace(way) for n, way in ways.items() if way.trace is not None}
    written["reorder"] = {name: _late(way.reorder) for name, way in ways.items()}
    written["duplication"] = {name: _late(way.duplication) for name, way in ways.items()}
    if channel.options:
        written["link"] = _plain(channel.options)
    return written


def _connection(connection: Connection) -> str | dict[str, Any]:
    written: dict[str, Any] = {"from": str(connection.source), "to": str(connection.target)}
    if connection.via is not None:
        written["via"] = connection.via
    if connection.rate is not None:
        written["rate"] = _exact(connection.rate)
    if connection.delay.ticks:
        written["delay"] = _delay(connection.delay)
    if connection.initial != "source":
        written["initial"] = connection.initial
    is_short = written.keys() <= {"from", "to", "via"} and " " not in f"{connection.source}"
    return str(connection) if is_short and " " not in str(connection.target) else written


def _record(record: Record) -> str | dict[str, Any]:
    if record.rate is None:
        return record.pattern
    return {"signals": record.pattern, "rate": _exact(record.rate)}


def _exact(value: Fraction) -> int | float | str:
    """A number where that says it exactly, else ``a/b`` as text."""
    if value.denominator == 1:
        return value.numerator
    text = format_exact(value)
    return text if "/" in text else float(text)


def _delay(delay: Delay) -> int | str:
    return delay.samples if delay.samples is not None else _ticks(delay.ticks)


def _ticks(ticks: int) -> str:
    return "1 tick" if ticks == 1 else f"{ticks} ticks"


def _jitter(jitter: Jitter, channel: Channel) -> int | str | dict[str, Any]:
    most = len(jitter.weights) - 1
    if jitter.weights == Jitter.uniform(most):
        if most == 0 or jitter.step == channel.period:
            return most
        if jitter.step == 1:
            return _ticks(most)
    return {"weights": list(jitter.weights), "step": _ticks(jitter.step)}


def _loss(way: Direction) -> float | dict[str, float]:
    if isinstance(way.loss, Bernoulli):
        return way.loss.probability
    return {
        "good_to_bad": way.loss.good_to_bad,
        "bad_to_good": way.loss.bad_to_good,
        "loss_good": way.loss.loss_good,
        "loss_bad": way.loss.loss_bad,
    }


def _late(late: Reorder | Duplication) -> float | dict[str, Any]:
    if not late.probability:
        return 0.0
    return {"probability": late.probability, "by": _ticks(late.ticks)}


def _trace(way: Direction) -> str | list[str]:
    if way.trace_file is not None:
        return str(way.trace_file)
    return ["lost" if ticks < 0 else _ticks(ticks) for ticks in way.trace or (0,)]


def _plain(value: Any) -> Any:
    """Plain data without tuples and read-only mappings."""
    if isinstance(value, Mapping):
        members = cast("Mapping[str, Any]", value)
        return {key: _plain(member) for key, member in members.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in cast("list[Any]", value)]
    return value
