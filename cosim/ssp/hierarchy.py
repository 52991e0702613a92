"""What a system structure consists of: components by their paths, and what drives each connector.

Hierarchy is resolved: a component's input is followed through the connectors of the systems around
it to the output that drives it. What drives is told by the kinds of connectors, not by ``start``
and ``end``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from cosim.base.component import Variable
from cosim.base.document.plain_name import plain_name
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit, unit_of
from cosim.base.suggest import did_you_mean
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.reading import read_description
from cosim.ssp.conversions import between
from cosim.ssp.documents import place
from cosim.ssp.structure import SspComponent, SspConnection, SspStructure, SspSystem, is_sink

_INDEX = re.compile(r"(.+?)(\[[\d,]+\])?")
Path = tuple[str, ...]
"""The names of the elements around and of an element itself, from the root on."""
Port = tuple[Path, str]


@dataclass(frozen=True, slots=True)
class DrivenBy:
    """Where a value comes from, and what happens to it on the way."""

    source: Port
    connection: SspConnection


class Hierarchy:
    """The elements of a structure, read."""

    def __init__(self, structure: SspStructure) -> None:
        """Read every FMU.

        Raises:
            InputError: one is missing, or a connection joins what it cannot.
        """
        self.file = structure.file
        self._units = structure.units
        self.systems: dict[Path, SspSystem] = {}
        self.components: dict[Path, SspComponent] = {}
        self.names: dict[Path, str] = {}
        """What the components are called in the scenario."""
        self.fmus: dict[Path, FmuDescription] = {}
        self.drivers: dict[Port, DrivenBy] = {}
        """Where the value of each connector comes from."""
        self._collect(structure.system, ())

    def variable(self, path: Path, name: str) -> Variable:
        """A component's variable, or that of which ``name`` is an element.

        Raises:
            InputError: there is none.
        """
        bare = _INDEX.fullmatch(name)
        variables = self.fmus[path].variables
        variable = variables.get(name) or (variables.get(bare[1]) if bare else None)
        if variable is None:
            raise InputError(
                f"{'.'.join(path)} has no variable '{name}'.{did_you_mean(name, variables)}"
            )
        return variable

    def unit(self, path: Path, variable: Variable) -> Unit | None:
        """The unit of a component's variable."""
        return self.fmus[path].interface("", feedthrough=False).unit(variable.name)

    def unit_at(self, port: Port) -> Unit | None:
        """The unit of a connector: that of the FMU's variable, else what the connector says."""
        path, connector = port
        element = self.components.get(path) or self.systems[path]
        if path in self.components:
            own = self.unit(path, self.variable(path, connector))
            if own is not None:
                return own
        bare = _INDEX.fullmatch(connector)
        name = element.units.get(bare[1] if bare else connector)
        return None if name is None else self._units.get(name) or unit_of(name)

    def knows_unit(self, port: Port) -> bool:
        """Whether the FMU says the unit of a component's variable."""
        return self.unit(port[0], self.variable(*port)) is not None

    def contradictions(self) -> list[str]:
        """What connectors say that their FMU does not; where it is the unit, the FMU counts."""
        found: list[str] = []
        for path, component in self.components.items():
            found += self._strangers(path, component)
            for name, written in component.units.items():
                variable = self.fmus[path].variables.get(name)
                own = None if variable is None else self.unit(path, variable)
                said = self._units.get(written) or unit_of(written)
                if own is not None and own != said and not _same(own, said):
                    where = f"{'.'.join(path)}.{name}"
                    found.append(
                        f"the connector {where} is in {written} and its FMU's variable in "
                        f"{own.name}: the FMU's unit counts"
                    )
        return found

    def _strangers(self, path: Path, component: SspComponent) -> Iterator[str]:
        """Connectors that the FMU has not, or has of another kind or type."""
        fmu = self.fmus[path]
        clocks = set[str]() if fmu.events is None else fmu.events.clock_names()
        for name, kind in component.kinds.items():
            where, variable = f"the connector {'.'.join(path)}.{name}", fmu.variables.get(name)
            if name in clocks or name in fmu.skipped:
                continue
            if variable is None:
                yield f"{where} is of nothing that its FMU has"
                continue
            if kind not in {"unspecified", "inout", str(variable.causality)}:
                own = f"its FMU's variable is of causality {variable.causality}"
                yield f"{where} is written as of kind {kind}; {own}"
            said = component.types.get(name, "")
            if said and _family(said) != _family(str(variable.type)):
                yield f"{where} is written as {said}; its FMU's variable is of type {variable.type}"

    def _collect(self, system: SspSystem, at: Path) -> None:
        self.systems[at] = system
        for name, element in system.elements.items():
            path = (*at, name)
            if isinstance(element, SspSystem):
                self._collect(element, path)
                continue
            if not element.source.exists():
                raise InputError(
                    f"there is no {element.source} for the component '{name}'.",
                    place(self.file, element.element),
                )
            self.components[path] = element
            description = read_description(element.source.absolute())
            mode = element.own.get("event_mode")
            self.fmus[path] = description.in_mode(None if mode is None else plain(mode))
            self.names[path] = self._name(path)
        for connection in system.connections:
            self._add(connection, system, at)

    def _name(self, path: Path) -> str:
        wanted = plain_name("_".join(path)) or "component"
        name, number = wanted, 2
        while name in self.names.values():
            name, number = f"{wanted}_{number}", number + 1
        return name

    def _add(self, connection: SspConnection, system: SspSystem, at: Path) -> None:
        ends = [
            self._end(end, connection, system, at) for end in (connection.start, connection.end)
        ]
        sinks = [sink for _, sink in ends]
        if sinks[0] == sinks[1]:
            what = "take values" if sinks[0] else "give values"
            raise InputError(
                f"both ends of the connection from {_shown(connection.start)} to "
                f"{_shown(connection.end)} {what}.",
                place(self.file, connection.element),
            )
        target, source = (ends[0][0], ends[1][0]) if sinks[0] else (ends[1][0], ends[0][0])
        if target in self.drivers:
            raise InputError(
                f"{'.'.join(target[0])}.{target[1]} is driven twice.",
                place(self.file, connection.element),
            )
        self.drivers[target] = DrivenBy(source, connection)

    def _end(
        self, end: tuple[str | None, str], connection: SspConnection, system: SspSystem, at: Path
    ) -> tuple[Port, bool]:
        """A port, and whether it takes values from this connection."""
        name, connector = end
        bare = _INDEX.fullmatch(connector)
        key = bare[1] if bare else connector
        if name is None:
            kind = system.kinds.get(connector, system.kinds.get(key))
            if kind is None:
                raise InputError(
                    f"the system '{system.name}' has no connector '{connector}'."
                    f"{did_you_mean(connector, system.kinds)}",
                    place(self.file, connection.element),
                )
            return (at, connector), is_sink(kind, outside=False)
        element = system.elements.get(name)
        if element is None:
            raise InputError(
                f"the system '{system.name}' has no element '{name}'."
                f"{did_you_mean(name, system.elements)}",
                place(self.file, connection.element),
            )
        kind = element.kinds.get(connector, element.kinds.get(key, "unspecified"))
        if isinstance(element, SspComponent):
            try:
                variable = self.variable((*at, name), connector)
            except InputError as error:
                raise InputError(error.message, place(self.file, connection.element)) from None
            kind = str(variable.causality) if kind == "unspecified" else kind
        elif key not in element.kinds and connector not in element.kinds:
            raise InputError(
                f"the system '{name}' has no connector '{connector}'."
                f"{did_you_mean(connector, element.kinds)}",
                place(self.file, connection.element),
            )
        return ((*at, name), connector), is_sink(kind, outside=True)


def _family(kind: str) -> str:
    """What values of a type are, whatever room they take."""
    if kind in {"Real", "Float32", "Float64"}:
        return "real"
    return "whole" if kind == "Enumeration" or "Int" in kind else kind


def _same(one: Unit, other: Unit) -> bool:
    try:
        return between(one, other).changes_nothing
    except ValueError:
        return False


def plain(text: str) -> Any:
    """An attribute of our annotation as the scalar that it was."""
    known: Mapping[str, Any] = {"true": True, "false": False}
    if text in known:
        return known[text]
    return int(text) if text.isdecimal() else text


def _shown(end: tuple[str | None, str]) -> str:
    return f"{end[0]}.{end[1]}" if end[0] else end[1]
