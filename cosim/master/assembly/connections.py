"""From connections to wires: which elements are joined, and whether they may be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from cosim.base.component import Causality, Role, Variable, VariableType
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.assembly.connecting.bundles import Bundles
from cosim.master.assembly.connecting.conversions import Conversions
from cosim.master.assembly.connecting.ends import Pair, join, name_of
from cosim.master.assembly.connecting.matching import check_input, match_elements
from cosim.master.assembly.knobs import Knobs
from cosim.master.assembly.wiring import Signal, Source, Wire, Wiring
from cosim.master.components.interface import Interface, Selection
from cosim.scenario import Connection, Kind, Scenario
from cosim.scenario.build.dials import targets_of


class _Wirer:
    def __init__(
        self,
        scenario: Scenario,
        interfaces: Mapping[str, Interface],
        knobs: Knobs,
        problems: Problems,
    ) -> None:
        self.wiring = Wiring()
        self._scenario = scenario
        self._interfaces = interfaces
        self._knobs = knobs
        self._problems = problems
        self._bundles = Bundles(scenario, knobs, self.wiring.bundles)
        self._conversions = Conversions(scenario, interfaces, self.wiring.notes)

    def run(self) -> Wiring:
        # Packets come first: a connection may start from what another one says about its packets.
        order = sorted(
            enumerate(self._scenario.connections),
            key=lambda item: item[1].source.component in self._scenario.channels,
        )
        for number, connection in order:
            with self._problems.at(("connections", number)):
                self._connect(connection)
        return self.wiring

    def _connect(self, connection: Connection) -> None:
        pairs = list(self._pairs(connection))
        self._conversions.check_unit_ignored(connection, pairs)
        bundle = self._bundles.of(connection)
        for pair in pairs:
            self._check_driver(connection, pair)
            self._check_measurable(connection, pair)
            gain, offset, from_integer = self._conversions.of(connection, pair)
            source: Source = pair.source
            if bundle is not None:
                source = self._bundles.enter(bundle, connection, pair)
            self.wiring.wires.append(Wire(source, pair.target, gain, offset, from_integer))

    def _pairs(self, connection: Connection) -> Iterator[Pair]:
        if connection.target.component in self._scenario.channels:
            yield from self._to_channel(connection)
            return
        target = self._interface(connection.target.component)
        selected = target.select(connection.target.path)
        if connection.source.component in self._scenario.channels:
            yield self._from_packet(connection, target, selected)
            return
        source = self._interface(connection.source.component)
        origin = source.select(connection.source.path)
        for there, here in match_elements(connection, source, origin, target, selected):
            yield join(source, there, target, here)

    def _to_channel(self, connection: Connection) -> Iterator[Pair]:
        """What turns a channel: one value, perhaps for both directions."""
        channel = self._scenario.channels[connection.target.component]
        dials = targets_of(channel, connection.target.path)
        if any((channel.name, dial) not in self._knobs.all for dial in dials):
            raise _Known(channel.name)
        source = self._interface(connection.source.component)
        origin = source.select(connection.source.path)
        target = self._knobs.channels[channel.name]
        for dial in dials:
            selected = target.select(dial)
            for there, here in match_elements(connection, source, origin, target, selected):
                yield join(source, there, target, here)

    def _from_packet(self, connection: Connection, target: Interface, selected: Selection) -> Pair:
        fact = self._bundles.packet_fact(connection.source.component, connection.source.path)
        if len(selected.members) != 1:
            raise InputError(f"{connection}: {connection.source} is one value, the input is not")
        (element,) = selected.members.values()
        check_input(connection, target, element)
        variable = Variable(
            name=fact.name, type=VariableType.INT64, causality=Causality.OUTPUT, unit="1"
        )
        return Pair(
            fact,
            variable,
            None,
            Signal(target.component, element.variable, element.index),
            target.variables[element.variable],
            None,
        )

    def _interface(self, component: str) -> Interface:
        interface = self._interfaces.get(component)
        if interface is not None:
            return interface
        if component in self._scenario.components:
            raise _Known(component)
        hint = did_you_mean(component, self._scenario.components)
        raise InputError(f"there is no component '{component}'.{hint}")

    def _check_driver(self, connection: Connection, pair: Pair) -> None:
        if pair.target_variable.type.is_text and self._uses_events(pair.target.component):
            raise InputError(
                f"{connection}: {pair.target.variable} is a {pair.target_variable.type}, which "
                "changes between two events; that is not carried in event mode (write "
                f"'event_mode: false' at {pair.target.component})"
            )
        other = self.wiring.connection_of.get(pair.target)
        if other is not None:
            raise InputError(
                f"{name_of(self._interfaces, pair.target)} is driven twice: by {other} and by "
                f"{connection}; remove one"
            )
        self.wiring.connection_of[pair.target] = str(connection)

    def _uses_events(self, component: str) -> bool:
        interface = self._interfaces.get(component)
        return interface is not None and interface.events is not None

    def _check_measurable(self, connection: Connection, pair: Pair) -> None:
        """A device has no value for what only a simulation knows, so nothing may be fed by it."""
        source = self._scenario.components.get(connection.source.component)
        if source is None or source.kind is not Kind.DEVICE:
            return
        if pair.source_variable.role is Role.SIMULATION_ONLY:
            raise InputError(
                f"{connection}: {source.name} is a device, which cannot measure "
                f"{pair.source_variable.name}; only a simulated one has it"
            )


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
