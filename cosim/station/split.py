"""From a scenario of several stations to what one of them runs and what it sends and receives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from fractions import Fraction

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.base.suggest import did_you_mean
from cosim.link.stream.bundle import PacketBundle
from cosim.link.stream.form import read_link
from cosim.link.stream.remote import LINK_FACTS, STREAM_FACTS
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Bundle as WiredBundle
from cosim.master.assembly.wiring import Held, Signal, Wire
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
from cosim.scenario.source.notation import components_in
from cosim.station.half import Half, Peer
from cosim.station.peer_inputs import peer_inputs
from cosim.station.signals import StationSignals, identifier, reference


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
        self.signals = StationSignals(assembly)
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
                if (parts := components_in(name)) and kept.keys() >= set(parts)
            },
        )
        return Half(self.own, scenario, tuple(self.peers.values()), tuple(self.dropped))

    def _drop_turned_channels(self) -> None:
        """A link between two machines is as it is; what a channel simulates can be turned."""
        for channel, dials in self.assembly.knobs.dials().items():
            self.dropped += [f"what turns {channel}.{dial}" for dial in sorted(dials)]

    def _drop_expectations_of_the_whole(self) -> None:
        """What is expected of a component is judged at its station, what of several nowhere."""
        stations = {name: part.station for name, part in self.scenario.components.items()}
        names = [
            target
            for target in self.scenario.expect
            if len({stations.get(part) for part in components_in(target)} - {None}) != 1
        ]
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
            self.signals.name(entry.source): self.signals.field(entry.source)
            for entry in bundle.entries
            if isinstance(entry.source, Signal)
        }
        for entry in bundle.entries:
            self.signals.refuse_text(entry.source, channel)
        peer = self._peer(target if source == self.own else source)
        list_ = peer.sends if source == self.own else peer.receives
        name = bundle.name.rsplit(".", 1)[0] if " at " not in bundle.name else bundle.name
        linked = PacketBundle(
            source=source,
            target=target,
            channel=identifier(name),
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
                            source=reference(signal.component, self.signals.path(signal)),
                            target=reference(peer.component, self.signals.name(signal)),
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
            self._receive(peer, origin, wire, via)
        for fact, input_ in peer_inputs(self.assembly, self.signals, number, wires):
            self._connect_fact(peer, linked, fact, input_, via)

    def _receive(self, peer: Peer, origin: Signal, wire: Wire, via: str | None) -> None:
        """Connect a value that comes from a peer as the scenario connects it."""
        target = wire.target
        written = self._written[self.assembly.wiring.connection_of[target]]
        if via is None and written.initial == "start":
            self._drop(
                f"'initial: start' of {written}, for a peer sends its values before the start"
            )
        # What samples and delays is at the other end of the link, or the link itself.
        like = written if via else replace(written, rate=None, period=None, initial="source")
        ignores = written.ignores_unit and self.signals.are_units_apart(origin, target)
        if self.signals.has_own_unit(origin) and self.signals.are_units_apart(origin, target):
            # A link knows a unit of the peer's FMU by name alone.
            like = replace(like, factor=wire.gain, offset=wire.offset)
            ignores = True
        self.connections.append(
            replace(
                like,
                source=reference(peer.component, self.signals.name(origin)),
                target=reference(target.component, self.signals.path(target)),
                via=via,
                ignores_unit=ignores,
            )
        )

    def _sampled(self, connection: Connection, bundle: WiredBundle) -> Connection:
        """Through a channel, at the rate of a bundle; the link has its own."""
        if connection.via is None:
            return connection
        rate = self.scenario.base_rate / bundle.period
        return replace(connection, rate=rate, period=bundle.period)

    def _drop(self, sentence: str) -> None:
        if sentence not in self.dropped:
            self.dropped.append(sentence)

    def _connect_fact(
        self, peer: Peer, bundle: PacketBundle, fact: str, target: Reference, via: str | None
    ) -> None:
        """Connect what the link says of a stream; simulated impairments on top add to its age."""
        source = reference(peer.component, f"{bundle.channel}.{fact}")
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
            self._connect(source, reference(helper, "at_link"), via)
            self._connect(reference(via, f"{way}.age"), reference(helper, "on_the_way"), None)
        self._connect(reference(helper, "total"), target, None)

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
