"""From connections to wires: names, sizes, types, units and stations are checked here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from cosim.base.component import Causality, Role, Variable, VariableType
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit, conversion
from cosim.base.suggest import did_you_mean
from cosim.master.assembly.knobs import Knobs
from cosim.master.assembly.wiring import (
    Bundle,
    Entry,
    Held,
    PacketFact,
    Signal,
    Source,
    Wire,
    Wiring,
)
from cosim.master.channels.fates import Fates, fates_of
from cosim.master.components.interface import Element, Interface, Selection
from cosim.scenario import Connection, Direction, Kind, Scenario
from cosim.scenario.build.dials import targets_of

_AGE = {"age": "ticks since the held packet was sampled", "sequence": "number of the held packet"}
_PACKET_UNIT = Unit("1", (0,) * 8)


@dataclass(frozen=True, slots=True)
class _Pair:
    """One source element and the input element it drives."""

    source: Signal | PacketFact
    source_variable: Variable
    source_unit: Unit | None
    target: Signal
    target_variable: Variable
    target_unit: Unit | None


@dataclass(slots=True)
class _Wirer:
    scenario: Scenario
    interfaces: Mapping[str, Interface]
    knobs: Knobs
    problems: Problems
    wiring: Wiring = field(default_factory=Wiring)
    bundles: dict[tuple[str, str, int], int] = field(
        default_factory=dict[tuple[str, str, int], int]
    )

    def run(self) -> Wiring:
        # Packets come first: a connection may start from what another one says about its packets.
        order = sorted(
            enumerate(self.scenario.connections),
            key=lambda item: item[1].source.component in self.scenario.channels,
        )
        for number, connection in order:
            with self.problems.at(("connections", number)):
                self._connect(connection)
        return self.wiring

    def _connect(self, connection: Connection) -> None:
        pairs = list(self._pairs(connection))
        self._check_unit_ignored(connection, pairs)
        bundle = self._bundle(connection)
        for pair in pairs:
            self._check_driver(connection, pair)
            self._check_measurable(connection, pair)
            gain, offset, from_integer = self._transformed(connection, pair)
            source: Source = pair.source
            if bundle is not None:
                source = self._enter(bundle, connection, pair)
            self.wiring.wires.append(Wire(source, pair.target, gain, offset, from_integer))

    def _pairs(self, connection: Connection) -> Iterator[_Pair]:
        if connection.target.component in self.scenario.channels:
            yield from self._to_channel(connection)
            return
        target = self._interface(connection.target.component)
        selected = target.select(connection.target.path)
        if connection.source.component in self.scenario.channels:
            yield self._from_packet(connection, target, selected)
            return
        source = self._interface(connection.source.component)
        origin = source.select(connection.source.path)
        for there, here in match_elements(connection, source, origin, target, selected):
            yield _Pair(
                Signal(source.component, there.variable, there.index),
                source.variables[there.variable],
                source.unit(there.variable),
                Signal(target.component, here.variable, here.index),
                target.variables[here.variable],
                target.unit(here.variable),
            )

    def _to_channel(self, connection: Connection) -> Iterator[_Pair]:
        """What turns a channel: one value, perhaps for both directions."""
        channel = self.scenario.channels[connection.target.component]
        dials = targets_of(channel, connection.target.path)
        if any((channel.name, dial) not in self.knobs.all for dial in dials):
            raise _Known(channel.name)
        source = self._interface(connection.source.component)
        origin = source.select(connection.source.path)
        target = self.knobs.channels[channel.name]
        for dial in dials:
            selected = target.select(dial)
            for there, here in match_elements(connection, source, origin, target, selected):
                yield _Pair(
                    Signal(source.component, there.variable, there.index),
                    source.variables[there.variable],
                    source.unit(there.variable),
                    Signal(channel.name, here.variable, here.index),
                    target.variables[here.variable],
                    target.unit(here.variable),
                )

    def _from_packet(self, connection: Connection, target: Interface, selected: Selection) -> _Pair:
        fact = self.packet_fact(connection.source.component, connection.source.path)
        if len(selected.members) != 1:
            raise InputError(f"{connection}: {connection.source} is one value, the input is not")
        (element,) = selected.members.values()
        _check_input(connection, target, element)
        variable = Variable(
            name=fact.name, type=VariableType.INT64, causality=Causality.OUTPUT, unit="1"
        )
        return _Pair(
            fact,
            variable,
            None,
            Signal(target.component, element.variable, element.index),
            target.variables[element.variable],
            None,
        )

    def packet_fact(self, channel: str, path: str) -> PacketFact:
        """``forward.age`` and the like of a channel."""
        way, _, name = path.partition(".")
        if way not in {"forward", "backward"} or name not in _AGE:
            known = [f"{way}.{name}" for way in ("forward", "backward") for name in _AGE]
            raise InputError(
                f"channel {channel} has no signal '{path}'.{did_you_mean(path, known)}"
            )
        period = self.scenario.channels[channel].period
        bundle = self.bundles.get((channel, way, period))
        if bundle is None:
            raise InputError(
                f"nothing is sent {way} through channel {channel}, so it has no {name}"
            )
        return PacketFact(bundle, name)

    def _interface(self, component: str) -> Interface:
        interface = self.interfaces.get(component)
        if interface is not None:
            return interface
        if component in self.scenario.components:
            raise _Known(component)
        hint = did_you_mean(component, self.scenario.components)
        raise InputError(f"there is no component '{component}'.{hint}")

    def _bundle(self, connection: Connection) -> int | None:
        if connection.target.component in self.scenario.channels:
            return None
        components = self.scenario.components
        there = components.get(connection.source.component)
        here = components[connection.target.component]
        if connection.via is None:
            if there is not None and there.station != here.station:
                raise InputError(
                    f"{connection} goes from station {there.station} to station {here.station} "
                    "without a channel; add 'via' and the channel's name"
                )
            return self._sampler(connection)
        channel = self.scenario.channels.get(connection.via)
        if channel is None:
            hint = did_you_mean(connection.via, self.scenario.channels)
            raise InputError(f"there is no channel '{connection.via}'.{hint}")
        if there is None:
            raise InputError(f"{connection}: what a channel says about packets stays where it is")
        ends = (there.station, here.station)
        if ends not in {channel.between, channel.between[::-1]}:
            raise InputError(
                f"{connection}: channel {channel.name} joins {' and '.join(channel.between)}, not "
                f"{ends[0]} and {ends[1]}"
            )
        way = "forward" if ends == channel.between else "backward"
        period = connection.period or channel.period
        key = (channel.name, way, period)
        if key not in self.bundles:
            rate = self.scenario.base_rate / period
            fates = fates_of(
                self.scenario.seed,
                channel.name,
                way,
                rate,
                channel.direction(*ends),
                extremes=self.knobs.extremes(channel.name, way),
            )
            name = f"{channel.name}.{way}"
            if period != channel.period:
                name += f" at {float(rate):g} Hz"
            self.bundles[key] = self._add(Bundle(name, channel.name, way, period, fates))
        return self.bundles[key]

    def _sampler(self, connection: Connection) -> int | None:
        if connection.period is None and connection.delay.ticks == 0:
            return None
        source = self.scenario.components.get(connection.source.component)
        own = source.period if source is not None else 1
        period = connection.period or own
        fates = Fates(direction=Direction(delay=connection.delay), key=0)
        return self._add(Bundle(str(connection), None, "", period, fates))

    def _add(self, bundle: Bundle) -> int:
        self.wiring.bundles.append(bundle)
        return len(self.wiring.bundles) - 1

    def _enter(self, bundle: int, connection: Connection, pair: _Pair) -> Held:
        start = pair.target if connection.initial == "start" else None
        entries = self.wiring.bundles[bundle].entries
        entries.append(Entry(pair.source, pair.source_variable.type.is_float, start))
        return Held(bundle, len(entries) - 1)

    def _check_driver(self, connection: Connection, pair: _Pair) -> None:
        if pair.target_variable.type.is_text and self._uses_events(pair.target.component):
            raise InputError(
                f"{connection}: {pair.target.variable} is a {pair.target_variable.type}, which "
                "changes between two events; that is not carried in event mode (write "
                f"'event_mode: false' at {pair.target.component})"
            )
        other = self.wiring.connection_of.get(pair.target)
        if other is not None:
            raise InputError(
                f"{_name(self.interfaces, pair.target)} is driven twice: by {other} and by "
                f"{connection}; remove one"
            )
        self.wiring.connection_of[pair.target] = str(connection)

    def _uses_events(self, component: str) -> bool:
        interface = self.interfaces.get(component)
        return interface is not None and interface.events is not None

    def _check_measurable(self, connection: Connection, pair: _Pair) -> None:
        """A device has no value for what only a simulation knows, so nothing may be fed by it."""
        source = self.scenario.components.get(connection.source.component)
        if source is None or source.kind is not Kind.DEVICE:
            return
        if pair.source_variable.role is Role.SIMULATION_ONLY:
            raise InputError(
                f"{connection}: {source.name} is a device, which cannot measure "
                f"{pair.source_variable.name}; only a simulated one has it"
            )

    def _check_unit_ignored(self, connection: Connection, pairs: list[_Pair]) -> None:
        """What is to be ignored has to be there."""
        if connection.ignores_unit and all(
            conversion(pair.source_unit, pair.target_unit) == (1.0, 0.0)
            and pair.source_variable.is_relative == pair.target_variable.is_relative
            for pair in pairs
        ):
            raise InputError(f"{connection}: the units of both ends agree; leave 'unit' out")

    def _is_playback(self, connection: Connection) -> bool:
        """A record keeps booleans as whole numbers; the kernel sees to it that they are 0 or 1."""
        source = self.scenario.components.get(connection.source.component)
        return source is not None and source.kind is Kind.PLAYBACK

    def _transformed(self, connection: Connection, pair: _Pair) -> tuple[float, float, bool]:
        gain, offset, from_integer = self._conversion(connection, pair)
        if (connection.factor, connection.offset) == (1.0, 0.0):
            return gain, offset, from_integer
        if not pair.target_variable.type.is_float:
            raise InputError(
                f"{connection}: {_name(self.interfaces, pair.target)} is of type "
                f"{pair.target_variable.type}; only a real input takes a factor or an offset"
            )
        factor = connection.factor
        return factor * gain, factor * offset + connection.offset, from_integer

    def _conversion(self, connection: Connection, pair: _Pair) -> tuple[float, float, bool]:
        there, here = pair.source_variable, pair.target_variable
        names = f"{_source_name(self.interfaces, connection, pair)} ({there.type})"
        into = f"{_name(self.interfaces, pair.target)} ({here.type})"
        if (there.type.is_text or here.type.is_text) and there.type is not here.type:
            raise InputError(f"{names} cannot drive {into}: texts and binary data keep their type")
        from_integer = here.type.is_float and not there.type.is_float
        if from_integer and there.type in {VariableType.BOOLEAN, VariableType.ENUMERATION}:
            raise InputError(f"{names} cannot drive {into}: it is not a number")
        if there.type.is_float and not here.type.is_float:
            raise InputError(f"{names} cannot drive {into}: a real value does not fit an integer")
        integer = not there.type.is_float and not here.type.is_float
        if (
            integer
            and here.type is VariableType.BOOLEAN
            and there.type is not here.type
            and (not self._is_playback(connection))
        ):
            raise InputError(f"{names} cannot drive {into}: only a boolean can")
        if connection.ignores_unit:
            return (1.0, 0.0, from_integer)
        ends = {there.is_relative: pair.source_unit, here.is_relative: pair.target_unit}
        if len(ends) == 2 and (absolute := ends[False]) is not None and absolute.offset:
            raise InputError(
                f"{names} cannot drive {into}: one is a difference (relativeQuantity), "
                f"the other an absolute value in {absolute.name}"
            )
        factor = conversion(pair.source_unit, pair.target_unit)
        if factor is None and (unknown := _known_by_name_only(pair)):
            self.wiring.notes.append(
                f"{connection}: nobody says what {unknown} measures, so {there.unit} passes to "
                f"{here.unit} as it is (unit: ignore says so without a note)"
            )
            return (1.0, 0.0, from_integer)
        if factor is None:
            raise InputError(
                f"{_source_name(self.interfaces, connection, pair)} is in {there.unit} and "
                f"{_name(self.interfaces, pair.target)} in {here.unit}; they measure different "
                "things (unit: ignore on the connection passes the number as it is)"
            )
        if factor != (1.0, 0.0):
            if not here.type.is_float:
                raise InputError(f"{names} in {there.unit} cannot drive {into} in {here.unit}")
            self.wiring.notes.append(f"{connection}: {there.unit} is converted to {here.unit}")
        return (*factor, from_integer)


def _known_by_name_only(pair: _Pair) -> str:
    """The unit of either end that is only a word."""
    units = (pair.source_unit, pair.target_unit)
    return next((unit.name for unit in units if unit is not None and unit.exponents is None), "")


class _Known(InputError):
    """What an end names could not be read: its own error has been reported."""

    def __init__(self, name: str) -> None:
        super().__init__(name)


def wire(
    scenario: Scenario, interfaces: Mapping[str, Interface], knobs: Knobs, problems: Problems
) -> Wiring:
    """Resolve and check every connection; what is wrong goes to ``problems`` with its place.

    ``interfaces`` are those of components, and of channels that are turned.
    """
    problems.ignore(_Known)
    return _Wirer(scenario, interfaces, knobs, problems).run()


def match_elements(
    connection: Connection,
    source: Interface,
    origin: Selection,
    target: Interface,
    selected: Selection,
) -> Iterator[tuple[Element, Element]]:
    """Pairs of elements: by place for variables and arrays, by name for terminals and groups."""
    if origin.named != selected.named:
        raise InputError(
            f"{connection} joins {_a(origin.kind)} to {_a(selected.kind)}; give both ends as "
            "variables, or both as terminals or groups"
        )
    if origin.named:
        pairs = [
            (element, selected.members[member])
            for member, element in origin.members.items()
            if member in selected.members
            and source.variables[element.variable].causality in _READABLE
            and target.variables[selected.members[member].variable].causality is Causality.INPUT
        ]
        if not pairs:
            outputs = [
                member
                for member, element in origin.members.items()
                if source.variables[element.variable].causality in _READABLE
            ]
            inputs = [
                member
                for member, element in selected.members.items()
                if target.variables[element.variable].causality is Causality.INPUT
            ]
            raise InputError(
                f"{connection}: no output of {connection.source} ({_list(outputs)}) has the name "
                f"of an input of {connection.target} ({_list(inputs)})"
            )
        yield from pairs
        return
    if len(origin.members) != len(selected.members):
        raise InputError(
            f"{connection}: {connection.source} has {_count(origin)} and {connection.target} "
            f"{_count(selected)}"
        )
    for there, here in zip(origin.members.values(), selected.members.values(), strict=True):
        if source.variables[there.variable].causality not in _READABLE:
            causality = source.variables[there.variable].causality
            raise InputError(
                f"{connection}: {connection.source} is {_a(causality)}, not an output"
                + (", turn the arrow round" if causality is Causality.INPUT else "")
            )
        _check_input(connection, target, here)
        yield there, here


_READABLE = {Causality.OUTPUT}


def _check_input(connection: Connection, target: Interface, element: Element) -> None:
    causality = target.variables[element.variable].causality
    if causality is not Causality.INPUT and element.variable not in target.knobs:
        raise InputError(f"{connection}: {connection.target} is {_a(causality)}, not an input")


def _name(interfaces: Mapping[str, Interface], signal: Signal) -> str:
    interface = interfaces[signal.component]
    return f"{signal.component}.{interface.element_name(Element(signal.variable, signal.index))}"


def _source_name(interfaces: Mapping[str, Interface], connection: Connection, pair: _Pair) -> str:
    source = pair.source
    return _name(interfaces, source) if isinstance(source, Signal) else str(connection.source)


def _a(word: str) -> str:
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def _count(selection: Selection) -> str:
    number = len(selection.members)
    return "one element" if number == 1 else f"{number} elements"


def _list(names: list[str]) -> str:
    return ", ".join(names[:6]) + (" …" if len(names) > 6 else "") if names else "none"
