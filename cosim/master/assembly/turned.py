"""From a scenario to its knobs: what events, connections and ``knobs`` itself name."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from math import gcd
from typing import Any

from cosim.base.component import Causality, Variable
from cosim.base.document.node import PathKey
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.master.assembly.knobs import Knob, Knobs, Name, Turn
from cosim.master.components.interface import Interface, is_tunable
from cosim.master.components.parameters import element_start
from cosim.master.components.participant import Participant
from cosim.master.components.tunable import named, tunable_at
from cosim.scenario import Channel, Connection, Event, KnobRange, Record, Reference, Scenario
from cosim.scenario.build.dials import (
    DELAY,
    WAYS,
    description_of,
    dials,
    reading,
    targets_of,
    unit_of,
)


def read_knobs(
    scenario: Scenario, participants: dict[str, Participant], problems: Problems
) -> Knobs:
    """Everything that is turned, with its range; the interfaces learn of their knobs.

    What is wrong goes to ``problems`` with its place.
    """
    return _Reader(scenario, Knobs(scenario, participants), problems).read()


@dataclass(slots=True)
class _Reader:
    scenario: Scenario
    knobs: Knobs
    problems: Problems
    places: dict[tuple[Name, int], Event] = field(default_factory=dict[tuple[Name, int], Event])
    """The event that comes into force at a tick."""

    def read(self) -> Knobs:
        for written in self.scenario.knobs:
            with self.problems.at(written.written):
                self._declare(written)
        for number, connection in enumerate(self.scenario.connections):
            path = ("connections", number)
            with self.problems.at(path):
                self._connect(connection, path)
        for number, record in enumerate(self.scenario.record):
            with self.problems.at(("record", number)):
                self._record(record)
        turns: list[Turn] = []
        for event in self.scenario.events:
            with self.problems.at(event.written):
                turns += self._event(event)
        self.knobs.turns = tuple(turns)
        for (owner, variable), knob in self.knobs.all.items():
            self._interface(owner, knob.variable).make_knob(variable)
        return self.knobs

    def _interface(self, owner: str, variable: Variable) -> Interface:
        if owner not in self.scenario.channels:
            return self.knobs.participants[owner].interface
        empty = Interface(component=owner, variables={}, feedthrough=False)
        interface = self.knobs.channels.setdefault(owner, empty)
        interface.variables = {**interface.variables, variable.name: variable}
        return interface

    def _declare(self, written: KnobRange) -> None:
        target = written.target
        for name in self._names(target):
            knob, where = self._knob(name), ".".join(name)
            for key in ("minimum", "maximum"):
                bound = getattr(written, key)
                if bound is not None:
                    setattr(knob, key, self._bound(target, knob, bound))
            if target.component in self.scenario.channels and not knob.is_bounded:
                if written.maximum is None:
                    raise InputError(
                        f"{where} needs a 'maximum': room for its packets is made before the start"
                    )
                knob.minimum = 0.0 if written.minimum is None else knob.minimum
            if knob.minimum > knob.maximum:
                raise InputError(
                    f"{where}: the minimum, {knob.minimum:g}, is more than the maximum, "
                    f"{knob.maximum:g}"
                )
            knob.is_bounded = True
            self.knobs.check_range(name, knob.start)

    def _bound(self, target: Reference, knob: Knob, bound: Any) -> float:
        """An end of a range; each element of an array has the same."""
        count = len(knob.start)
        reference = Reference(component=target.component, path=knob.variable.name)
        found = self.knobs.meant(reference, [bound] * count if knob.variable.shape else bound)
        return float(next(iter(found.values()))[0])

    def _connect(self, connection: Connection, path: tuple[PathKey, ...]) -> None:
        target = connection.target
        if target.component in self.scenario.channels:
            channel = self.scenario.channels[target.component]
            names = [(channel.name, dial) for dial in targets_of(channel, target.path)]
        elif target.component in self.knobs.participants:
            interface = self.knobs.participants[target.component].interface
            tunable = [v for v in named(interface, target.path) if is_tunable(v)]
            names = [(target.component, variable.name) for variable in tunable]
        else:
            return
        for name in names:
            knob, where = self._knob(name), ".".join(name)
            knob.connection = str(connection)
            if not knob.is_bounded:
                self.problems.add(
                    path,
                    f"{connection} turns {where}, and nothing says how far, which must be known "
                    f"before the start; write 'knobs: {{{where}: {{maximum: …}}}}'.",
                )

    def _record(self, record: Record) -> None:
        """What could be turned and is recorded by its name has a value, too, that stays."""
        component, _, path = record.pattern.partition(".")
        channel = self.scenario.channels.get(component)
        if channel is not None:
            way, _, name = path.partition(".")
            names = [path] if way in WAYS and name in {DELAY, *dials()} else []
        elif component in self.knobs.participants:
            interface = self.knobs.participants[component].interface
            names = [v.name for v in named(interface, path) if is_tunable(v)]
        else:
            names = []
        for name in names:
            self._knob((component, name))

    def _event(self, event: Event) -> list[Turn]:
        turns: list[Turn] = []
        if not self._names(event.target):
            return turns
        for name, elements in self.knobs.meant(event.target, event.value).items():
            knob = self._knob(name)
            if knob.is_bounded:
                self.knobs.check_range(name, elements)
            else:
                knob.minimum = min(knob.minimum, *elements)
                knob.maximum = max(knob.maximum, *elements)
            self._check_event(event, name, knob)
            turns.append(Turn(event.tick, name, tuple(elements)))
        return turns

    def _check_event(self, event: Event, name: Name, knob: Knob) -> None:
        where = ".".join(name)
        tick = self.knobs.effective(name, event.tick)
        if tick >= self.scenario.ticks:
            raise InputError(
                f"{where} is turned at tick {event.tick} and would come into force at tick {tick}; "
                f"the run ends before that, with tick {self.scenario.ticks - 1}"
            )
        if knob.connection:
            raise InputError(
                f"{where} is driven by {knob.connection}, so that an event would not last; remove "
                "one of them"
            )
        other = self.places.setdefault((name, tick), event)
        if other is not event:
            when = f"at tick {event.tick}"
            if other.tick != event.tick:
                when = f"at ticks {other.tick} and {event.tick}, both in force from tick {tick} on"
            place = self.scenario.locate(other.written)
            raise InputError(f"{where} is turned twice {when}; the other is at {place}; remove one")

    def _names(self, target: Reference) -> list[Name]:
        """What a target stands for; nothing where its component could not be read."""
        component = target.component
        if component in self.scenario.channels:
            return [(component, target.path)]
        if component not in self.knobs.participants:
            return []
        interface = self.knobs.participants[component].interface
        return [(component, name) for name in tunable_at(interface, target.path)]

    def _knob(self, name: Name) -> Knob:
        """The knob of that name; it is made where there is none."""
        if name not in self.knobs.all:
            channel = self.scenario.channels.get(name[0])
            made = self._of_component(*name) if channel is None else self._dial(channel, name[1])
            self.knobs.all[name] = made
        return self.knobs.all[name]

    def _of_component(self, component: str, variable: str) -> Knob:
        participant = self.knobs.participants[component]
        described = participant.interface.variables[variable]
        items = (described.items or {}).values()
        least, most = (min(items), max(items)) if items else _limits(described)
        return Knob(
            variable=described,
            period=participant.period,
            start=participant.parameters.get(variable) or element_start(described),
            minimum=-math.inf if least is None else least,
            maximum=math.inf if most is None else most,
            is_bounded=True,
        )

    def _dial(self, channel: Channel, dial: str) -> Knob:
        way, _, name = dial.partition(".")
        start, unit = reading(channel, way, name, self.scenario.base_rate), unit_of(name)
        is_share = unit == "1"
        variable = Variable(
            name=dial,
            causality=Causality.PARAMETER,
            variability="tunable",
            unit=unit,
            start=start,
            minimum=0.0,
            maximum=1.0 if is_share else None,
            description=description_of(name),
        )
        return Knob(
            variable=variable,
            period=_packet_period(self.scenario, channel),
            start=[start],
            minimum=0.0 if is_share else start,
            maximum=1.0 if is_share else start,
            is_bounded=is_share,
        )


def _limits(variable: Variable) -> tuple[float | None, float | None]:
    """What it declares, within what its type can hold."""
    least, most = variable.minimum, variable.maximum
    if variable.type.limits is not None:
        low, high = variable.type.limits
        least = low if least is None else max(least, low)
        most = high if most is None else min(most, high)
    return least, most


def _packet_period(scenario: Scenario, channel: Channel) -> int:
    """After how many ticks a packet may be sent, whatever its connection's rate."""
    periods = [c.period or channel.period for c in scenario.connections if c.via == channel.name]
    return gcd(*periods) if periods else channel.period
