"""What may be turned while a scenario runs: tunable parameters and dials of channels.

A knob is turned by events, by a connection, or by hand between two ticks. It has its value in
force, which others see and which is recorded, and beside it the value that is wanted; the kernel
takes the one over into the other when its component, or the channel's next packet, is due.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cosim.base.component import Causality, Variable
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.components.interface import Interface
from cosim.master.components.parameters import resolve_values
from cosim.master.components.participant import Participant
from cosim.master.components.tunable import tunable_at
from cosim.scenario import Direction, Reference, Scenario
from cosim.scenario.build.dials import settings, turned

Name = tuple[str, str]
"""A component or channel, and its variable."""
Turned = dict[Name, list[Any]]
"""The elements that knobs are turned to."""


@dataclass(slots=True)
class Knob:
    """One knob; ``period`` is after how many ticks it can come into force."""

    variable: Variable
    period: int
    start: list[Any]
    minimum: float
    maximum: float
    is_bounded: bool
    """Whether it is said how far it goes; else it goes as far as its events."""
    connection: str = ""
    """What drives it, if something does."""


@dataclass(frozen=True, slots=True)
class Turn:
    """An event: a knob is turned at the beginning of a tick."""

    tick: int
    name: Name
    elements: tuple[Any, ...]


@dataclass(slots=True)
class Knobs:
    """Every knob of a run, and what its events do with them."""

    scenario: Scenario
    participants: Mapping[str, Participant]
    channels: dict[str, Interface] = field(default_factory=dict[str, Interface])
    """The dials in use of each channel, as connections see them."""
    all: dict[Name, Knob] = field(default_factory=dict[Name, Knob])
    turns: tuple[Turn, ...] = ()

    def judge(self, target: str, value: Any) -> Turned:
        """What a value that is written for a knob means.

        Raises:
            InputError: there is no such knob, or the value is none of it.
        """
        component, _, path = target.partition(".")
        known = {*self.participants, *self.scenario.channels}
        if component not in known:
            raise InputError(
                f"there is no component or channel '{component}'.{did_you_mean(component, known)}"
            )
        if component in self.scenario.channels:
            channel = self.scenario.channels[component]
            value = settings(channel, path, value, self.scenario.base_rate)
            found = {(component, dial): [setting] for dial, setting in value.items()}
        else:
            found = self.meant(Reference(component=component, path=path), value)
        for name, elements in found.items():
            self.check_range(name, elements)
        return found

    def meant(self, target: Reference, value: Any) -> Turned:
        """What a value of a scenario means, in which those of channels are in SI units already.

        Raises:
            InputError: there is nothing of that name to turn, or the value does not fit it.
        """
        name = target.component
        if name in self.scenario.channels:
            return {(name, target.path): [value]}
        participant = self.participants[name]
        tunable_at(participant.interface, target.path)
        found = resolve_values(
            name,
            participant.interface.variables,
            target.path,
            value,
            frozenset({Causality.PARAMETER}),
            units={} if participant.fmu is None else participant.fmu.units,
        )
        return {(name, variable): elements for variable, elements in found.items()}

    def check_range(self, name: Name, elements: list[Any]) -> None:
        """Whether a knob goes so far.

        Raises:
            InputError: it does not, or it is none of this scenario.
        """
        where = ".".join(name)
        knob = self.all.get(name)
        if knob is None:
            known = [".".join(other) for other in self.all]
            raise InputError(
                f"{where} is no knob of this scenario: name it under 'knobs'."
                f"{did_you_mean(where, known)}"
            )
        unit = f" {knob.variable.unit}" if knob.variable.unit not in {None, "", "1"} else ""
        for element in elements:
            if not knob.minimum <= element <= knob.maximum:
                raise InputError(
                    f"{where} cannot be {element:g}{unit}: it goes from {knob.minimum:g}{unit} to "
                    f"{knob.maximum:g}{unit}"
                )

    def effective(self, name: Name, tick: int) -> int:
        """When a knob that is turned before a tick comes into force."""
        period = self.all[name].period
        return -(-tick // period) * period

    def ranges(self) -> dict[Name, tuple[float, float]]:
        """How far each knob goes, which is compiled into the plan."""
        return {name: (knob.minimum, knob.maximum) for name, knob in self.all.items()}

    def dials(self) -> dict[str, dict[str, int]]:
        """What may be turned of each channel, and after how many ticks it can come into force."""
        found: dict[str, dict[str, int]] = {}
        for (owner, variable), knob in self.all.items():
            if owner in self.channels:
                found.setdefault(owner, {})[variable] = knob.period
        return found

    def extremes(self, channel: str, way: str) -> tuple[Direction, ...]:
        """The direction with all its dials at their least, and at their most."""
        knobs = {
            name.partition(".")[2]: knob
            for (owner, name), knob in self.all.items()
            if owner == channel and name.startswith(f"{way}.")
        }
        written: Direction = getattr(self.scenario.channels[channel], way)
        ends = ({n: k.minimum for n, k in knobs.items()}, {n: k.maximum for n, k in knobs.items()})
        base_rate = self.scenario.base_rate
        return tuple(turned(written, end, base_rate) for end in ends) if knobs else ()
