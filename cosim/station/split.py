"""From a scenario of several stations to what one of them runs and what it sends and receives."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from fractions import Fraction

from cosim.base.component import Causality
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.quantities.units import conversion
from cosim.base.suggest import did_you_mean
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.link.stream.form import read_link
from cosim.link.stream.remote import LINK_FACTS, STREAM_FACTS
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Bundle as WiredBundle
from cosim.master.assembly.wiring import Held, PacketFact, Signal, Source, Wire
from cosim.master.components.interface import Element
from cosim.scenario import (
    Channel,
    Connection,
    Direction,
    Kind,
    Record,
    Reference,
    ScenarioComponent,
)
from cosim.scenario.model import Value
from cosim.station.half import Half, Peer

PEER_FACTS = {
    Meaning.PEER_WEIGHT: "weight",
    Meaning.PEER_VALID: "valid",
    Meaning.PEER_AGE: "age",
}
"""What the link says of a peer to the inputs that mean it."""

FIRST = 1
"""The peer that a variable is of where it does not say."""


def split(assembly: Assembly, own: str) -> Half:
    """The part of station ``own``.

    Raises:
        InputError: there is no such station, nothing crosses to it, or a setting is wrong.
    """
    scenario = assembly.scenario
    if own not in scenario.stations:
        raise InputError(
            f"{scenario.name} has no station '{own}'.{did_you_mean(own, scenario.stations)}"
        )
    return _Splitter(assembly, own).split()


class _Splitter:
    def __init__(self, assembly: Assembly, own: str) -> None:
        self.assembly, self.own = assembly, own
        self.scenario = assembly.scenario
        self.peers: dict[str, Peer] = {}
        self.connections: list[Connection] = []
        self.channels: dict[str, Channel] = {}
        self.helpers: dict[str, ScenarioComponent] = {}
        """Components that only this half has, beside the remote stations."""
        self.dropped: list[str] = []
        self._written = {str(each): each for each in self.scenario.connections}
        """Every connection, as it was written."""

    def split(self) -> Half:
        self._drop_turned_channels()
        self._drop_expectations_of_the_whole()
        for number, bundle in enumerate(self.assembly.wiring.bundles):
            if bundle.channel is not None:
                self._cross(number, bundle)
        if not self.peers:
            raise InputError(
                f"nothing crosses a channel to or from station {self.own} in "
                f"{self.scenario.name}; run it with 'cohaptic run'"
            )
        self._keep_own_connections()
        kept = self._components()
        scenario = replace(
            self.scenario,
            components=kept,
            channels=self.channels,
            connections=tuple(self.connections),
            knobs=tuple(k for k in self.scenario.knobs if k.target.component in kept),
            events=tuple(e for e in self.scenario.events if e.target.component in kept),
            record=tuple(self._records(kept)),
            expect={
                name: wanted
                for name, wanted in self.scenario.expect.items()
                if name.partition(".")[0] in kept
            },
        )
        return Half(self.own, scenario, tuple(self.peers.values()), tuple(self.dropped))

    def _drop_turned_channels(self) -> None:
        """A link between two machines is as it is; what a channel simulates can be turned."""
        for channel, dials in self.assembly.knobs.dials().items():
            self.dropped += [f"what turns {channel}.{dial}" for dial in sorted(dials)]

    def _drop_expectations_of_the_whole(self) -> None:
        """What is expected of a component is judged at its station, what of all of them nowhere."""
        components = self.scenario.components
        names = [n for n in self.scenario.expect if n.partition(".")[0] not in components]
        if names:
            self.dropped.append(f"expect {', '.join(names)}")

    def _components(self) -> dict[str, ScenarioComponent]:
        own = {
            name: replace(part, parameters=self._parameters(part))
            for name, part in self.scenario.components.items()
            if part.station == self.own
        }
        for peer in self.peers.values():
            own[peer.component] = ScenarioComponent(
                name=peer.component,
                kind=Kind.PYTHON,
                source="cosim.link.stream.remote:RemoteStation",
                # With the simulated impairments on top, the channel still lies in between.
                station=peer.name if peer.adds else self.own,
                rate_name=None,
                rate=self.scenario.base_rate,
                period=1,
            )
        return own | self.helpers

    def _parameters(self, part: ScenarioComponent) -> dict[str, Value]:
        """With what follows from the rates of channels, which this half does not have."""
        participant = self.assembly.participants[part.name]
        variables = participant.interface.variables
        network = {
            name: values[0]
            for name, values in participant.parameters.items()
            if name in variables and variables[name].meaning_of() is Meaning.NETWORK_TICKS
        }
        return {**part.parameters, **network}

    def _peer(self, name: str) -> Peer:
        if name not in self.peers:
            component = f"link_{name}"
            while component in self.scenario.components:
                component += "_"
            self.peers[name] = Peer(name, component)
        return self.peers[name]

    def _cross(self, number: int, bundle: WiredBundle) -> None:
        assert bundle.channel is not None
        channel = self.scenario.channels[bundle.channel]
        ends = channel.between if bundle.way == "forward" else channel.between[::-1]
        source, target = ends
        if self.own not in ends:
            return
        fields = {
            self._element(entry.source): self._field(entry.source)
            for entry in bundle.entries
            if isinstance(entry.source, Signal)
        }
        for entry in bundle.entries:
            self._refuse_text(entry.source, channel)
        peer = self._peer(target if source == self.own else source)
        list_ = peer.sends if source == self.own else peer.receives
        name = bundle.name.rsplit(".", 1)[0] if " at " not in bundle.name else bundle.name
        linked = PacketBundle(
            source=source,
            target=target,
            channel=_identifier(name),
            fields=tuple(fields.values()),
            period=bundle.period,
            tick=Fraction(1) / self.scenario.base_rate,
            stream=len(list_),
        )
        list_.append(linked)
        settings = read_link({**self.scenario.link, **channel.options}, f"channel {channel.name}")
        peer.agree(channel.name, settings)
        via = channel.name if settings.add_impairments else None
        if via is not None:
            self._keep_impairments(channel)
        if source == self.own:
            for signal in dict.fromkeys(e.source for e in bundle.entries):
                assert isinstance(signal, Signal)
                self.connections.append(
                    self._sampled(
                        Connection(
                            source=_reference(signal.component, self._path(signal)),
                            target=_reference(peer.component, self._element(signal)),
                            via=via,
                        ),
                        bundle,
                    )
                )
            return
        peer.settings.append(settings)
        wires = [
            wire
            for wire in self.assembly.wiring.wires
            if isinstance(wire.source, Held) and wire.source.bundle == number
        ]
        for wire in wires:
            assert isinstance(wire.source, Held)
            origin = bundle.entries[wire.source.index].source
            assert isinstance(origin, Signal)
            self._receive(peer, origin, wire.target, via)
        self._drive_peer_inputs(number, linked, peer, wires, via)

    def _receive(self, peer: Peer, origin: Signal, target: Signal, via: str | None) -> None:
        """Connect a value that comes from a peer as the scenario connects it."""
        written = self._written[self.assembly.wiring.connection_of[target]]
        if via is None and written.initial == "start":
            self._drop(
                f"'initial: start' of {written}, for a peer sends its values before the start"
            )
        # What samples and delays is at the other end of the link, or the link itself.
        like = written if via else replace(written, rate=None, period=None, initial="source")
        self.connections.append(
            replace(
                like,
                source=_reference(peer.component, self._element(origin)),
                target=_reference(target.component, self._path(target)),
                via=via,
                ignores_unit=written.ignores_unit and self._are_units_apart(origin, target),
            )
        )

    def _are_units_apart(self, origin: Signal, target: Signal) -> bool:
        """Whether there is something to ignore between two elements of a connection."""
        here, there = (
            self.assembly.participants[end.component].interface for end in (origin, target)
        )
        relative = [
            interface.variables[end.variable].is_relative
            for interface, end in ((here, origin), (there, target))
        ]
        units = here.unit(origin.variable), there.unit(target.variable)
        return conversion(*units) != (1.0, 0.0) or relative[0] is not relative[1]

    def _sampled(self, connection: Connection, bundle: WiredBundle) -> Connection:
        """Through a channel, at the rate of a bundle; the link has its own."""
        if connection.via is None:
            return connection
        rate = self.scenario.base_rate / bundle.period
        return replace(connection, rate=rate, period=bundle.period)

    def _drop(self, sentence: str) -> None:
        if sentence not in self.dropped:
            self.dropped.append(sentence)

    def _refuse_text(self, source: Source, channel: Channel) -> None:
        """A packet of the link has numbers, eight bytes each."""
        if not isinstance(source, Signal):
            return
        interface = self.assembly.participants[source.component].interface
        if interface.variables[source.variable].type.is_text:
            raise InputError(
                f"{self._element(source)} goes through the channel {channel.name} and is a text; "
                "the link between stations carries numbers alone. Simulate it with 'cohaptic run', "
                "or connect numbers."
            )

    def _drive_peer_inputs(
        self,
        number: int,
        bundle: PacketBundle,
        peer: Peer,
        wires: Sequence[Wire],
        via: str | None,
    ) -> None:
        """Connect weight, validity and age to the inputs that wait for them, and packet facts."""
        driven = self.assembly.wiring.connection_of
        slots = dict.fromkeys(
            (wire.target.component, self._slot(wire.target).peer or FIRST) for wire in wires
        )
        for component, place in slots:
            interface = self.assembly.participants[component].interface
            for path, element in interface.elements.items():
                variable = interface.variables[element.variable]
                meaning = variable.meaning_of(element.index)
                fact = None if meaning is None else PEER_FACTS.get(meaning)
                if fact is None or variable.causality is not Causality.INPUT:
                    continue
                if (variable.slot_of(element.index).peer or FIRST) != place:
                    continue
                if Signal(component, element.variable, element.index) not in driven:
                    target = _reference(component, path)
                    self._connect_fact(peer, bundle, fact, target, via)
        for wire in self.assembly.wiring.wires:
            fact = wire.source
            if isinstance(fact, PacketFact) and fact.bundle == number:
                target = _reference(wire.target.component, self._path(wire.target))
                self._connect_fact(peer, bundle, fact.name, target, via)

    def _connect_fact(
        self, peer: Peer, bundle: PacketBundle, fact: str, target: Reference, via: str | None
    ) -> None:
        """Connect what the link says of a stream; simulated impairments on top add to its age."""
        source = _reference(peer.component, f"{bundle.channel}.{fact}")
        if fact != "age" or via is None:
            self._connect(source, target, via)
            return
        helper = f"{peer.component}_{bundle.channel}_age"
        if helper not in self.helpers:
            self.helpers[helper] = ScenarioComponent(
                name=helper,
                kind=Kind.PYTHON,
                source="cosim.link.stream.total_age:TotalAge",
                station=self.own,
                rate_name=None,
                rate=self.scenario.base_rate,
                period=1,
            )
            way = "forward" if self.channels[via].between[1] == self.own else "backward"
            self._connect(source, _reference(helper, "at_link"), via)
            self._connect(_reference(via, f"{way}.age"), _reference(helper, "on_the_way"), None)
        self._connect(_reference(helper, "total"), target, None)

    def _keep_own_connections(self) -> None:
        for connection in self.scenario.connections:
            there = self.scenario.components.get(connection.source.component)
            here = self.scenario.components.get(connection.target.component)
            if here is None or there is None:
                continue  # about a channel, or into one
            if there.station == here.station == self.own:
                self.connections.append(connection)

    def _keep_impairments(self, channel: Channel) -> None:
        """Keep what the simulated channel does to values on their way to this station."""
        ideal = Direction()
        forward, backward = channel.forward, channel.backward
        if channel.between[0] == self.own:
            forward = ideal
        else:
            backward = ideal
        self.channels[channel.name] = replace(channel, forward=forward, backward=backward)

    def _connect(self, source: Reference, target: Reference, via: str | None) -> None:
        self.connections.append(Connection(source=source, target=target, via=via))

    def _records(self, kept: dict[str, ScenarioComponent]) -> Iterator[Record]:
        others = [name for name in self.scenario.components if name not in kept]
        for record in self.scenario.record:
            component, _, _ = record.pattern.partition(".")
            here = [name for name in kept if fnmatchcase(name, component)]
            there = [name for name in others if fnmatchcase(name, component)]
            if here or not (there or component in self.scenario.channels):
                yield record
            else:
                self.dropped.append(f"record {record.pattern}")
        for peer in self.peers.values():
            facts = [
                f"{bundle.channel}.{fact}" for bundle in peer.receives for fact in STREAM_FACTS
            ]
            for fact in [*facts, *LINK_FACTS]:
                yield Record(pattern=f"{peer.component}.{fact}")

    def _field(self, signal: Signal) -> Field:
        variable = self.assembly.participants[signal.component].interface.variables[signal.variable]
        one = replace(variable, shape=(), meaning=variable.meaning_of(signal.index))
        return Field.of(one, self._element(signal))

    def _slot(self, signal: Signal) -> Slot:
        variables = self.assembly.participants[signal.component].interface.variables
        return variables[signal.variable].slot_of(signal.index)

    def _element(self, signal: Signal) -> str:
        return f"{signal.component}.{self._path(signal)}"

    def _path(self, signal: Signal) -> str:
        interface = self.assembly.participants[signal.component].interface
        return interface.element_name(Element(signal.variable, signal.index))


def _reference(component: str, path: str) -> Reference:
    return Reference(component=component, path=path)


def _identifier(name: str) -> str:
    """A channel's name that can be part of a variable's."""
    return re.sub(r"\W+", "_", name)
