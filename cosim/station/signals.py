"""The elements of an assembly as a link sees them: their names, their fields, whose they are."""

from __future__ import annotations

import re
from dataclasses import replace

from cosim.base.errors import InputError
from cosim.base.meaning import Slot
from cosim.base.quantities.units import conversion, unit_of
from cosim.link.stream.bundle import Field
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Signal, Source
from cosim.master.components.interface import Element
from cosim.scenario import Channel, Reference


class StationSignals:
    """Looks elements up in the interfaces of an assembly's components."""

    def __init__(self, assembly: Assembly) -> None:
        self._participants = assembly.participants

    def path(self, signal: Signal) -> str:
        """Its name in its component."""
        interface = self._participants[signal.component].interface
        return interface.element_name(Element(signal.variable, signal.index))

    def name(self, signal: Signal) -> str:
        """Its name in the scenario."""
        return f"{signal.component}.{self.path(signal)}"

    def field(self, signal: Signal) -> Field:
        """What carries it in a packet."""
        variable = self._participants[signal.component].interface.variables[signal.variable]
        one = replace(variable, shape=(), meaning=variable.meaning_of(signal.index))
        return Field.of(one, self.name(signal))

    def slot(self, signal: Signal) -> Slot:
        """Which finger and peer it is of."""
        variables = self._participants[signal.component].interface.variables
        return variables[signal.variable].slot_of(signal.index)

    def are_units_apart(self, origin: Signal, target: Signal) -> bool:
        """Whether there is something to ignore between two elements of a connection."""
        here, there = (self._participants[end.component].interface for end in (origin, target))
        relative = [
            interface.variables[end.variable].is_relative
            for interface, end in ((here, origin), (there, target))
        ]
        units = here.unit(origin.variable), there.unit(target.variable)
        return conversion(*units) != (1.0, 0.0) or relative[0] is not relative[1]

    def has_own_unit(self, signal: Signal) -> bool:
        """Whether only its own component says what its unit measures."""
        interface = self._participants[signal.component].interface
        unit = interface.units.get(interface.variables[signal.variable].unit or "")
        return unit is not None and unit.exponents is not None and unit != unit_of(unit.name)

    def refuse_text(self, source: Source, channel: Channel) -> None:
        """Refuse what no packet carries: one has numbers, eight bytes each.

        Raises:
            InputError: the source is a text.
        """
        if not isinstance(source, Signal):
            return
        interface = self._participants[source.component].interface
        if interface.variables[source.variable].type.is_text:
            raise InputError(
                f"{self.name(source)} goes through the channel {channel.name} and is a text; "
                "the link between stations carries numbers alone. Simulate it with 'cohaptic run', "
                "or connect numbers."
            )


def reference(component: str, path: str) -> Reference:
    """A component's element, as a connection names it."""
    return Reference(component=component, path=path)


def identifier(name: str) -> str:
    """A channel's name that can be part of a variable's."""
    return re.sub(r"\W+", "_", name)
