"""A loaded scenario written out again as one self-contained YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import groupby
from typing import Any, cast

from cosim.base.document.yaml_writer import write_yaml
from cosim.base.quantities.quantity import format_exact
from cosim.scenario.build.dials import written
from cosim.scenario.impairments.impairment import Impairment
from cosim.scenario.impairments.registry import impairments
from cosim.scenario.model import (
    Channel,
    Connection,
    Delay,
    Direction,
    Event,
    Kind,
    KnobRange,
    Record,
    Reference,
    Scenario,
    ScenarioComponent,
    Value,
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
    if scenario.start_tick:
        document["start_time"] = _exact(scenario.start_time)
    if scenario.knobs:
        document["knobs"] = {str(knob.target): _knob(scenario, knob) for knob in scenario.knobs}
    if scenario.events:
        document["events"] = [
            _events_at(scenario, tick, list(events))
            for tick, events in groupby(scenario.events, lambda event: event.tick)
        ]
    return document


def _events_at(scenario: Scenario, tick: int, events: list[Event]) -> dict[str, Any]:
    turned = {str(event.target): _setting(scenario, event.target, event.value) for event in events}
    return {"at": _ticks(tick), "set": turned}


def _knob(scenario: Scenario, knob: KnobRange) -> dict[str, Any]:
    bounds = {"minimum": knob.minimum, "maximum": knob.maximum}
    return {
        name: _setting(scenario, knob.target, bound)
        for name, bound in bounds.items()
        if bound is not None
    }


def _setting(scenario: Scenario, target: Reference, value: Value) -> Any:
    if target.component not in scenario.channels:
        return _plain(value)
    assert isinstance(value, float)
    return written(target.path.partition(".")[2], value, scenario.base_rate)


def _component(part: ScenarioComponent) -> dict[str, Any]:
    source: Any = part.source
    if part.kind is Kind.DEVICE and part.options:
        source = {"url": part.source, **_plain(part.options)}
    written: dict[str, Any] = {part.kind.value: source}
    if part.kind is Kind.PLAYBACK:
        written["of"] = part.options["component"]
    if part.kind is Kind.TABLE:
        if part.options["columns"]:
            written["columns"] = list(part.options["columns"])
        written["interpolate"] = part.options["interpolate"]
        written["time_offset"] = _exact(part.options["time_offset"])
    written |= {"station": part.station, "rate": part.rate_name or _exact(part.rate)}
    if part.kind is Kind.FMU:
        if part.is_bundled:
            written["flavour"] = part.flavour
        written |= {"substeps": part.substeps, "feedthrough": part.feedthrough}
        if part.is_strict:
            written["validate"] = "strict"
        if part.is_isolated:
            written["isolate"] = "process"
        if part.event_mode is not None:
            written["event_mode"] = part.event_mode
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
    kinds = impairments()
    replaced = {
        key for way in ways.values() for name in way.impairments for key in kinds[name].replaces
    }
    if "delay" not in replaced:
        written["delay"] = {name: _delay(way.delay) for name, way in ways.items()}
    for key, kind in kinds.items():
        by_way = {name: _effect(way, kind, channel) for name, way in ways.items()}
        known = {name: effect for name, effect in by_way.items() if effect is not None}
        if known and key not in replaced:
            written[key] = known
    if channel.options:
        written["link"] = _plain(channel.options)
    return written


def _effect(way: Direction, kind: Impairment, channel: Channel) -> Any:
    effect = way.impairments.get(kind.name)
    return kind.absent if effect is None else effect.write(channel.period)


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
    if connection.factor != 1.0:
        written["factor"] = connection.factor
    if connection.offset != 0.0:
        written["offset"] = connection.offset
    if connection.ignores_unit:
        written["unit"] = "ignore"
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


def _plain(value: Any) -> Any:
    """Plain data without tuples and read-only mappings."""
    if isinstance(value, Mapping):
        members = cast("Mapping[str, Any]", value)
        return {key: _plain(member) for key, member in members.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in cast("list[Any]", value)]
    return value
