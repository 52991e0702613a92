"""From a system structure to the document of a scenario.

Hierarchy is resolved: a component's input is followed through the connectors of the systems around
it to the output that drives it. What drives is told by the kinds of connectors, not by ``start``
and ``end``. Later parameter bindings win, and outer ones over inner ones.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from cosim.base.component import Causality, Variable
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.base.quantities.quantity import format_exact
from cosim.base.quantities.units import Unit, conversion
from cosim.base.suggest import did_you_mean
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.reading import read_description
from cosim.ssp.documents import place
from cosim.ssp.parameters import GivenValue, in_unit
from cosim.ssp.structure import SspComponent, SspConnection, SspStructure, SspSystem, is_sink

_SETTABLE = frozenset({Causality.PARAMETER, Causality.STRUCTURAL_PARAMETER})
_INDEX = re.compile(r"(.+?)(\[[\d,]+\])?")
Path = tuple[str, ...]
"""The names of the elements around and of an element itself, from the root on."""
Port = tuple[Path, str]
DEFAULT_STEP = Fraction(1, 100)
"""(s) of a component for which nobody says one."""


@dataclass(frozen=True, slots=True)
class _Edge:
    """Where a value comes from, and what happens to it on the way."""

    source: Port
    connection: SspConnection


@dataclass(slots=True)
class _Importer:
    structure: SspStructure
    stop_time: Fraction | None
    notes: list[str]
    components: dict[Path, SspComponent] = field(default_factory=dict[Path, SspComponent])
    names: dict[Path, str] = field(default_factory=dict[Path, str])
    fmus: dict[Path, FmuDescription] = field(default_factory=dict[Path, FmuDescription])
    drivers: dict[Port, _Edge] = field(default_factory=dict[Port, _Edge])
    values: dict[Path, dict[str, Any]] = field(default_factory=dict[Path, dict[str, Any]])

    def document(self) -> dict[str, Any]:
        self._collect(self.structure.system, ())
        self._bind(self.structure.system, ())
        own = dict(self.structure.own)
        title = own.pop("title", self.structure.title)
        start = self._start(own)
        times = {"start_time": format_exact(start)} if start else {}
        duration = self._duration(own, start)
        rest = {"cohaptic": 1, "title": title, **times, "duration": duration, **own}
        return rest | {
            "components": {name: self._component(path) for path, name in self.names.items()},
            "connections": [*self._connections(), *own.get("connections", [])],
        }

    # --- what there is ---------------------------------------------------------------------------

    def _collect(self, system: SspSystem, at: Path) -> None:
        for name, element in system.elements.items():
            path = (*at, name)
            if isinstance(element, SspSystem):
                self._collect(element, path)
                continue
            if not element.source.exists():
                raise InputError(
                    f"there is no {element.source} for the component '{name}'.",
                    place(self.structure.file, element.element),
                )
            self.components[path] = element
            description = read_description(element.source.absolute())
            mode = element.own.get("event_mode")
            self.fmus[path] = description.in_mode(None if mode is None else _plain(mode))
            self.names[path] = self._name(path)
        for connection in system.connections:
            self._add(connection, system, at)

    def _name(self, path: Path) -> str:
        wanted = re.sub(r"\W", "_", "_".join(path)).lstrip("_0123456789") or "component"
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
                place(self.structure.file, connection.element),
            )
        target, source = (ends[0][0], ends[1][0]) if sinks[0] else (ends[1][0], ends[0][0])
        if target in self.drivers:
            raise InputError(
                f"{'.'.join(target[0])}.{target[1]} is driven twice.",
                place(self.structure.file, connection.element),
            )
        self.drivers[target] = _Edge(source, connection)

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
                    place(self.structure.file, connection.element),
                )
            return (at, connector), is_sink(kind, outside=False)
        element = system.elements.get(name)
        if element is None:
            raise InputError(
                f"the system '{system.name}' has no element '{name}'."
                f"{did_you_mean(name, system.elements)}",
                place(self.structure.file, connection.element),
            )
        kind = element.kinds.get(connector, element.kinds.get(key, "unspecified"))
        if kind == "unspecified" and isinstance(element, SspComponent):
            kind = self._kind_of((*at, name), connector)
        return ((*at, name), connector), is_sink(kind, outside=True)

    def _kind_of(self, path: Path, connector: str) -> str:
        variable = self.fmus[path].variables.get(connector)
        return "unspecified" if variable is None else str(variable.causality)

    # --- connections -----------------------------------------------------------------------------

    def _connections(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        for (path, connector), edge in self.drivers.items():
            if path not in self.components:
                continue
            factor, offset, ignores, own = 1.0, 0.0, False, dict[str, str]()
            source: Port = (path, connector)
            step: _Edge | None = edge
            while step is not None:
                connection = step.connection
                factor, offset = factor * connection.factor, factor * connection.offset + offset
                ignores = ignores or connection.ignores_unit
                own |= connection.own
                source = step.source
                step = self.drivers.get(source) if source[0] not in self.components else None
            if source[0] not in self.components:
                self.notes.append(
                    f"{'.'.join(path)}.{connector} is driven from outside of the system by "
                    f"{source[1]}: it keeps its start value"
                )
                continue
            variable = self._variable(path, connector)
            if variable.causality is not Causality.INPUT and variable.variability != "tunable":
                raise InputError(
                    f"{'.'.join(path)}.{connector} is a {variable.causality}, which a connection "
                    "cannot set"
                )
            written: dict[str, Any] = {
                "from": f"{self.names[source[0]]}.{source[1]}",
                "to": f"{self.names[path]}.{connector}",
            }
            if factor != 1.0:
                written["factor"] = factor
            if offset != 0.0:
                written["offset"] = offset
            if ignores and self._units_differ(source, (path, connector)):
                written["unit"] = "ignore"
            found.append(written | own)
        return found

    def _units_differ(self, source: Port, target: Port) -> bool:
        """Whether there is anything to ignore."""
        ends = [(path, self._variable(path, connector)) for path, connector in (source, target)]
        units = [self._unit(path, variable) for path, variable in ends]
        relative = [variable.is_relative for _, variable in ends]
        return conversion(*units) != (1.0, 0.0) or relative[0] != relative[1]

    def _unit(self, path: Path, variable: Variable) -> Unit | None:
        return self.fmus[path].interface("", feedthrough=False).unit(variable.name)

    def _variable(self, path: Path, name: str) -> Variable:
        bare = _INDEX.fullmatch(name)
        variables = self.fmus[path].variables
        variable = variables.get(name) or (variables.get(bare[1]) if bare else None)
        if variable is None:
            raise InputError(
                f"{'.'.join(path)} has no variable '{name}'.{did_you_mean(name, variables)}"
            )
        return variable

    # --- values ----------------------------------------------------------------------------------

    def _bind(self, system: SspSystem, at: Path) -> None:
        for name, element in system.elements.items():
            path = (*at, name)
            if isinstance(element, SspSystem):
                self._bind(element, path)
                continue
            for binding in element.bindings:
                self.notes += binding.notes
                for variable, value in binding.values.items():
                    self._set(path, variable, value)
        for binding in system.bindings:
            self.notes += binding.notes
            for name, value in binding.values.items():
                targets = self._targets(system, at, name)
                if not targets:
                    self.notes.append(f"nothing in {system.name} has the parameter {name}")
                for path, variable, moved in targets:
                    self._set(path, variable, value.moved(*moved))

    def _targets(
        self, system: SspSystem, at: Path, name: str
    ) -> list[tuple[Path, str, tuple[float, float]]]:
        """The components' variables that a name in a system means."""
        if name in system.kinds:
            return self._behind((at, name), (1.0, 0.0))
        for child, element in system.elements.items():
            if not name.startswith(f"{child}."):
                continue
            rest, path = name[len(child) + 1 :], (*at, child)
            if isinstance(element, SspSystem):
                return self._targets(element, path, rest)
            return [(path, rest, (1.0, 0.0))]
        return []

    def _behind(
        self, port: Port, moved: tuple[float, float]
    ) -> list[tuple[Path, str, tuple[float, float]]]:
        found: list[tuple[Path, str, tuple[float, float]]] = []
        for target, edge in self.drivers.items():
            if edge.source == port:
                factor, offset = edge.connection.factor, edge.connection.offset
                then = (factor * moved[0], factor * moved[1] + offset)
                if target[0] in self.components:
                    found.append((*target, then))
                else:
                    found += self._behind(target, then)
        return found

    def _set(self, path: Path, name: str, given: GivenValue) -> None:
        try:
            variable = self._variable(path, name)
        except InputError as error:
            self.notes.append(f"a parameter set: {error.message}")
            return
        unit = self._unit(path, variable)
        try:
            value = in_unit(given, unit)
        except ValueError as error:
            raise InputError(f"{'.'.join(path)}.{name}: {error}") from None
        if variable.meaning is Meaning.FILE and value:
            value = str((self.structure.file.parent / str(value)).absolute())
        self.values.setdefault(path, {})[name] = value

    def _component(self, path: Path) -> dict[str, Any]:
        component, values = self.components[path], self.values.get(path, {})
        own = {key: _plain(text) for key, text in component.own.items()}
        written: dict[str, Any] = {"fmu": str(component.source.absolute())}
        if "rate" not in own:
            written["rate"] = format_exact(1 / self._step(path))
        written |= own
        for section in ("parameters", "start"):
            named = {
                name: value
                for name, value in values.items()
                if (self._variable(path, name).causality in _SETTABLE) is (section == "parameters")
            }
            if named:
                written[section] = named
        return written

    def _step(self, path: Path) -> Fraction:
        text = self.components[path].step or self.structure.step
        if text is not None:
            return Fraction(text)
        step = self.fmus[path].step_size
        if step is None:
            self.notes.append(
                f"nobody says how long the steps of {'.'.join(path)} are: {float(DEFAULT_STEP):g} s"
            )
            return DEFAULT_STEP
        return step

    def _start(self, own: dict[str, Any]) -> Fraction:
        """When time begins (s); 0 where our own annotation says it."""
        if "start_time" in own or self.structure.start is None:
            return Fraction(0)
        return self._seconds("startTime", self.structure.start)

    def _seconds(self, what: str, text: str) -> Fraction:
        try:
            return Fraction(text)
        except ValueError:
            raise InputError(
                f"the {what} of {self.structure.file.name} is {text}, which is no time to run at."
            ) from None

    def _duration(self, own: dict[str, Any], start: Fraction) -> Any:
        if self.stop_time is not None:
            own.pop("duration", None)
            return self._between(start, self.stop_time)
        if "duration" in own:
            return own.pop("duration")
        if self.structure.stop is None:
            raise InputError(
                f"{self.structure.file.name} does not say how long to run; give --stop-time."
            )
        return self._between(start, self._seconds("stopTime", self.structure.stop))

    def _between(self, start: Fraction, stop: Fraction) -> str:
        if stop <= start:
            raise InputError(
                f"{self.structure.file.name} begins at {float(start):g} s and would stop at "
                f"{float(stop):g} s; give a later --stop-time."
            )
        return format_exact(stop - start)


def to_scenario(
    structure: SspStructure, stop_time: Fraction | None, notes: list[str]
) -> dict[str, Any]:
    """The document of a scenario that computes what the structure describes.

    ``stop_time`` (s) takes the place of the structure's; ``notes`` gets what is worth telling.

    Raises:
        InputError: something of it cannot be used here.
    """
    return _Importer(structure, stop_time, notes).document()


def _plain(text: str) -> Any:
    """An attribute of our annotation as the scalar that it was."""
    known: Mapping[str, Any] = {"true": True, "false": False}
    if text in known:
        return known[text]
    return int(text) if text.isdecimal() else text


def _shown(end: tuple[str | None, str]) -> str:
    return f"{end[0]}.{end[1]}" if end[0] else end[1]
