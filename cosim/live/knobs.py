"""What a page may turn while a scenario is played: the network, the coupling, the compensation.

The scenario is compiled for the ranges; each station has a ``panel`` whose values drive the dials
of its outgoing channels and the tunable parameters of its workstation. One knob may turn several.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import ceil, floor, isfinite
from typing import Any, Literal, cast

from cosim.base.errors import InputError
from cosim.live.hands import CROSSFADE, PANEL
from cosim.live.panel import KNOBS
from cosim.realtime.ring import Ring
from cosim.scenario import Channel, Scenario, ScenarioComponent

COPIES, SERVER = "distributed_workstation", "central_server"
ARCHITECTURES = {COPIES: "distributed", SERVER: "centralized", "remote_client": "centralized"}
SWITCH = "control"
MOST_DELAY = 4
"""Samples of round-trip delay."""
Rounding = Literal["none", "up", "down"]


@dataclass(frozen=True, slots=True, kw_only=True)
class KnobWire:
    """One thing that a knob turns: a value of a station's panel is ``factor`` times the knob's.

    ``rounding`` rounds half of the knob's value first, as a round-trip delay is shared out.
    """

    station: str
    target: str
    factor: float = 1.0
    rounding: Rounding = "none"

    def value(self, turned: float) -> float:
        """What the panel shows."""
        if self.rounding == "none":
            return self.factor * turned
        return self.factor * (ceil if self.rounding == "up" else floor)(turned / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PageKnob:
    """A slider of the page; values as the page shows them."""

    key: str
    label: str
    unit: str
    minimum: float
    maximum: float
    step: float
    start: float
    wires: tuple[KnobWire, ...] = field(repr=False)
    choices: tuple[str, ...] = ()
    """What a switch's values 0, 1 … are called; empty for a slider."""


def knob_of(told: Mapping[str, Any]) -> PageKnob:
    """What ``dataclasses.asdict`` made of a knob, after a way as JSON."""
    given = dict(told)
    wires = tuple(KnobWire(**wire) for wire in given.pop("wires"))
    choices = tuple(given.pop("choices"))
    return PageKnob(**given, wires=wires, choices=choices)


def knobs_of(scenario: Scenario) -> list[PageKnob]:
    """What may be turned of a scenario that is played.

    Raises:
        InputError: it is more than the panels hold.
    """
    found = [*_switches(scenario)]
    for channel in scenario.channels.values():
        found += _of_channel(channel, float(scenario.base_rate))
    found += _of_models(scenario)
    for station, wires in places(found).items():
        if len(wires) > KNOBS:
            raise InputError(
                f"{scenario.name}: there are {len(wires)} things to turn at {station}, and a panel "
                f"has room for {KNOBS}; play a scenario with fewer channels there."
            )
    return found


def with_panels(scenario: Scenario, knobs: list[PageKnob]) -> dict[str, Any]:
    """The document to lay over the scenario, as YAML holds it."""
    components: dict[str, Any] = {}
    connections: list[str] = []
    for station, wires in places(knobs).items():
        rate = next(p for p in scenario.components.values() if p.station == station)
        values = [0.0] * KNOBS
        for index, (knob, wire) in enumerate(wires):
            values[index] = wire.value(knob.start)
            connections.append(f"panel_{station}.value[{index + 1}] -> {wire.target}")
        components[f"panel_{station}"] = {
            "python": PANEL,
            "station": station,
            "rate": rate.rate_name or float(rate.rate),
            "parameters": {"start": values},
        }
    ranges: dict[str, Any] = {}
    for knob in knobs:
        for wire in knob.wires:
            ends = sorted((wire.value(knob.minimum), wire.value(knob.maximum)))
            unit = " s" if wire.target.endswith((".delay", ".jitter")) else 0
            least, most = (f"{end!r}{unit}" if unit else end for end in ends)
            ranges[wire.target] = {"minimum": least, "maximum": most}
    return {"components": components, "connections": connections, "knobs": ranges}


def others_events(scenario: Scenario, knobs: list[PageKnob]) -> list[dict[str, Any]]:
    """What the scenario turns itself, as YAML holds it, but for what people turn now."""
    turned = {wire.target for knob in knobs for wire in knob.wires}
    return [
        {
            "at": f"{event.tick} ticks",
            "set": {str(event.target): f"{event.value} s" if seconds else event.value},
        }
        for event in scenario.events
        if str(event.target) not in turned
        for seconds in [str(event.target).endswith((".delay", ".jitter"))]
    ]


def places(knobs: list[PageKnob]) -> dict[str, list[tuple[PageKnob, KnobWire]]]:
    """By station, what each value of its panel turns, in order."""
    found: dict[str, list[tuple[PageKnob, KnobWire]]] = {}
    for knob in knobs:
        for wire in knob.wires:
            found.setdefault(wire.station, []).append((knob, wire))
    return found


class Panels:
    """The server's side: what pages turn goes into the rings of the panels."""

    def __init__(self, knobs: list[PageKnob], rings: Mapping[str, Ring]) -> None:
        self._knobs = {knob.key: knob for knob in knobs}
        self._places, self._rings = places(knobs), rings
        self._values = {knob.key: knob.start for knob in knobs}

    def told(self) -> list[dict[str, Any]]:
        """For the page."""
        return [
            {
                "key": knob.key,
                "label": knob.label,
                "unit": knob.unit,
                "minimum": knob.minimum,
                "maximum": knob.maximum,
                "step": knob.step,
                "value": self._values[knob.key],
                "choices": knob.choices,
            }
            for knob in self._knobs.values()
        ]

    def hear(self, wish: Any) -> bool:
        """Turn what a page asks for (values by key); whether anything was turned."""
        if not isinstance(wish, Mapping):
            return False
        before = dict(self._values)
        for key, value in cast("Mapping[Any, Any]", wish).items():
            knob = self._knobs.get(key)
            if knob is None or type(value) not in {int, float} or not isfinite(value):
                continue
            if knob.choices and value not in range(len(knob.choices)):
                continue
            if knob.minimum <= value <= knob.maximum:
                self._values[knob.key] = float(value)
        if self._values == before:
            return False
        for station, ring in self._rings.items():
            row = [0.0] * KNOBS
            for index, (knob, wire) in enumerate(self._places[station]):
                row[index] = wire.value(self._values[knob.key])
            ring.write(row)
        return True


def _switches(scenario: Scenario) -> Iterator[PageKnob]:
    """Between two worlds that step beside each other: what each crossfade passes on."""
    fades = [part for part in scenario.components.values() if part.source == CROSSFADE]
    if fades:
        yield PageKnob(
            key=SWITCH,
            label="Control",
            unit="",
            minimum=0,
            maximum=1,
            step=1,
            start=float(cast("float", fades[0].parameters.get("position", 0.0))),
            wires=tuple(KnobWire(station=p.station, target=f"{p.name}.position") for p in fades),
            choices=_worlds(scenario, fades[0].name),
        )


def _worlds(scenario: Scenario, fade: str) -> tuple[str, str]:
    """What the two worlds of a crossfade are called: by their architecture, else by component."""
    found = {"first": "first", "second": "second"}
    for link in scenario.connections:
        side = link.target.path.partition("_")[0]
        if link.target.component == fade and side in found:
            part = scenario.components[link.source.component]
            found[side] = ARCHITECTURES.get(part.source, part.name)
    return found["first"], found["second"]


def _of_channel(channel: Channel, base_rate: float) -> Iterator[PageKnob]:
    """Delay, jitter and loss of both ways, where the scenario has nothing of its own there."""
    sample = channel.period / base_rate
    ticks = channel.forward.delay.ticks + channel.backward.delay.ticks
    drawn = {*channel.forward.impairments, *channel.backward.impairments}
    a, b = channel.between

    def ways(what: str, factor: float, rounded: bool = False) -> tuple[KnobWire, KnobWire]:
        roundings: tuple[Rounding, Rounding] = ("up", "down") if rounded else ("none", "none")
        return (
            KnobWire(
                station=a,
                target=f"{channel.name}.forward.{what}",
                factor=factor,
                rounding=roundings[0],
            ),
            KnobWire(
                station=b,
                target=f"{channel.name}.backward.{what}",
                factor=factor,
                rounding=roundings[1],
            ),
        )

    name = channel.name
    if ticks % channel.period == 0 and ticks // channel.period <= MOST_DELAY:
        yield PageKnob(
            key=f"{name}.round_trip_delay",
            label=f"Round-trip delay, {name}",
            unit="samples",
            minimum=0,
            maximum=MOST_DELAY,
            step=1,
            start=ticks // channel.period,
            wires=ways("delay", sample, rounded=True),
        )
    if "jitter" not in drawn:
        yield PageKnob(
            key=f"{name}.jitter",
            label=f"Jitter, {name}",
            unit="ms",
            minimum=0,
            maximum=round(sample * 1e3, 3),
            step=1.0,
            start=0,
            wires=ways("jitter", 1e-3),
        )
    if "loss" not in drawn:
        yield PageKnob(
            key=f"{name}.loss",
            label=f"Loss, {name}",
            unit="%",
            minimum=0,
            maximum=50,
            step=5,
            start=0,
            wires=ways("loss", 0.01),
        )


def _of_models(scenario: Scenario) -> Iterator[PageKnob]:
    parts = scenario.components.values()
    copies = [part for part in parts if part.source == COPIES]
    servers = [part for part in parts if part.source == SERVER]
    yield from _parameter(copies, "coupling_stiffness", "Coupling of the copies", (0, 200, 2.5))
    yield from _parameter(
        servers, "remote_normal_stiffness", "Coupler of the remote user", (50, 1000, 10)
    )
    worlds = [*copies, *servers]
    starts = {_start(part, f"compensation.{axis}") for part in worlds for axis in "xy"}
    if len(starts) == 1:
        start = starts.pop()
        yield PageKnob(
            key="compensation",
            label="Compensation b_c",
            unit="N·s/m",
            minimum=min(-3.0, start),
            maximum=max(0.0, start),
            step=0.1,
            start=start,
            wires=tuple(
                KnobWire(station=part.station, target=f"{part.name}.compensation.{axis}")
                for part in worlds
                for axis in "xy"
            ),
        )


def _parameter(
    parts: list[ScenarioComponent], name: str, label: str, ends: tuple[float, float, float]
) -> Iterator[PageKnob]:
    """A knob of parts that agree; where they differ, one knob would change what nobody turned."""
    starts = {_start(part, name) for part in parts}
    if len(starts) == 1:
        start = starts.pop()
        yield PageKnob(
            key=name,
            label=label,
            unit="N/m",
            minimum=min(ends[0], start),
            maximum=max(ends[1], start),
            step=ends[2],
            start=start,
            wires=tuple(KnobWire(station=p.station, target=f"{p.name}.{name}") for p in parts),
        )


def _start(part: ScenarioComponent, name: str) -> float:
    return float(cast("float", part.parameters.get(name, DEFAULTS.get(name, 0.0))))


DEFAULTS = {"coupling_stiffness": 77.5, "remote_normal_stiffness": 170.0}
"""Of the models, where a scenario says nothing."""
