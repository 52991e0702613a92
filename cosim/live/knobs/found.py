"""What a page may turn of a scenario that is played: the network, the coupling, the compensation.

One knob may turn several things. None is found where turning it would change what nobody turned.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import quantity
from cosim.live.hands import CROSSFADE
from cosim.live.knobs.page_knob import KnobWire, PageKnob, Rounding, places
from cosim.live.panel import KNOBS
from cosim.scenario import Channel, Scenario, ScenarioComponent

COPIES, SERVER = "distributed_workstation", "central_server"
ARCHITECTURES = {COPIES: "distributed", SERVER: "centralized", "remote_client": "centralized"}
SWITCH = "control"
MOST_DELAY = 4
"""Samples of round-trip delay."""
DEFAULTS = {"coupling_stiffness": 77.5, "remote_normal_stiffness": 170.0}
"""Of the models, where a scenario says nothing."""


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
            start=_start(fades[0], "position", "1"),
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
    """Delay, jitter and loss of both ways, where the scenario has nothing of its own there.

    A delay is shared by the ways as a round trip is; one that the scenario shares otherwise stays.
    """
    sample = channel.period / base_rate
    given = [channel.forward.delay.ticks, channel.backward.delay.ticks]
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
    round_trip, delays = sum(given) / channel.period, ways("delay", sample, rounded=True)
    shared = [round(wire.value(round_trip) * base_rate) for wire in delays]
    if given == shared and round_trip <= MOST_DELAY:
        yield PageKnob(
            key=f"{name}.round_trip_delay",
            label=f"Round-trip delay, {name}",
            unit="samples",
            minimum=0,
            maximum=MOST_DELAY,
            step=1,
            start=round_trip,
            wires=delays,
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
    starts = {_start(part, f"compensation.{axis}", "N.s/m") for part in worlds for axis in "xy"}
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
    starts = {_start(part, name, "N/m") for part in parts}
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


def _start(part: ScenarioComponent, name: str, unit: str) -> float:
    given = cast("float | str", part.parameters.get(name, DEFAULTS.get(name, 0.0)))
    return float(quantity(given, unit))
