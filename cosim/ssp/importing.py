"""From a system structure to the document of a scenario."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from cosim.base.component import Causality
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import decimal, format_exact
from cosim.base.quantities.units import Unit, conversion
from cosim.ssp.bindings import BoundValues
from cosim.ssp.conversions import UNCHANGED, Linear, between
from cosim.ssp.documents import place
from cosim.ssp.hierarchy import DrivenBy, Hierarchy, Path, Port, plain
from cosim.ssp.structure import SspConnection, SspStructure
from cosim.ssp.times import duration_of, start_of

_SETTABLE = frozenset({Causality.PARAMETER, Causality.STRUCTURAL_PARAMETER})
DEFAULT_STEP = Fraction(1, 100)
"""(s) of a component for which nobody says one."""


class _Importer:
    def __init__(self, structure: SspStructure, notes: list[str]) -> None:
        self._structure = structure
        self._notes = notes
        self._hierarchy = Hierarchy(structure)
        self._values = BoundValues(self._hierarchy, notes)
        self._values.bind(structure.system, ())
        notes += self._hierarchy.contradictions()

    def document(self, stop_time: Fraction | None, start_time: Fraction | None) -> dict[str, Any]:
        own = dict(self._structure.own)
        title = own.pop("title", self._structure.title)
        start = start_of(self._structure, own) if start_time is None else start_time
        own.pop("start_time", None)
        times = {"start_time": format_exact(start)} if start else {}
        duration = duration_of(self._structure, own, start, stop_time)
        rest = {"cohaptic": 1, "title": title, **times, "duration": duration, **own}
        names = self._hierarchy.names.items()
        parts, more = own.get("components", {}), own.get("connections", [])
        if not isinstance(parts, dict) or not isinstance(more, list):
            raise InputError(
                f"the annotation of {self._structure.file.name} has components that are no "
                "mapping, or connections that are no list."
            )
        return rest | {
            "components": {name: self._component(path) for path, name in names} | parts,
            "connections": [*self._connections(), *more],
        }

    def _connections(self) -> list[dict[str, Any]]:
        hierarchy, found = self._hierarchy, list[dict[str, Any]]()
        for (path, connector), edge in hierarchy.drivers.items():
            if path not in hierarchy.components:
                continue
            edges, own = list[tuple[Port, DrivenBy]](), dict[str, str]()
            source: Port = (path, connector)
            target = source
            step: DrivenBy | None = edge
            while step is not None:
                edges.append((target, step))
                own |= step.connection.own
                source = target = step.source
                step = (
                    hierarchy.drivers.get(source) if source[0] not in hierarchy.components else None
                )
            if source[0] not in hierarchy.components:
                self._notes.append(
                    f"{'.'.join(path)}.{connector} is driven from outside of the system by "
                    f"{source[1]}: it keeps its start value"
                )
                continue
            variable = hierarchy.variable(path, connector)
            if variable.causality is not Causality.INPUT and variable.variability != "tunable":
                raise InputError(
                    f"{'.'.join(path)}.{connector} is a {variable.causality}, which a connection "
                    "cannot set"
                )
            written: dict[str, Any] = {
                "from": f"{hierarchy.names[source[0]]}.{source[1]}",
                "to": f"{hierarchy.names[path]}.{connector}",
            }
            written |= self._conversion(source, (path, connector), edges[::-1])
            found.append(written | own)
        return found

    def _conversion(
        self, source: Port, target: Port, edges: list[tuple[Port, DrivenBy]]
    ) -> dict[str, Any]:
        """What a connection has to say, so that each of these does what it says.

        ``edges`` are those between the two, with where each goes, in the order of the way.
        """
        is_relative = any(self._hierarchy.variable(*end).is_relative for end in (source, target))
        whole, unit = UNCHANGED, self._unit_at(source, is_relative=is_relative)
        for port, edge in edges:
            connection = edge.connection
            there = self._unit_at(port, is_relative=is_relative)
            if not connection.ignores_unit:
                whole = whole.then(self._between(unit, there, connection))
            unit = unit if there is None else there
            whole = whole.then(Linear.of(connection.factor, connection.offset))
        found: dict[str, Any] = {}
        first = UNCHANGED
        if any(edge.connection.ignores_unit for _, edge in edges):
            if self._units_differ(source, target):
                found["unit"] = "ignore"
        else:
            # What the run does by itself.
            ends = [self._unit_at(end, is_relative=is_relative) for end in (source, target)]
            if all(self._hierarchy.knows_unit(end) for end in (source, target)):
                first = self._between(ends[0], ends[1], edges[-1][1].connection)
        rest = whole.behind(first)
        if rest.factor != 1:
            found["factor"] = float(rest.factor)
        if rest.offset != 0:
            found["offset"] = float(rest.offset)
        return found

    def _unit_at(self, port: Port, *, is_relative: bool) -> Unit | None:
        """The unit of a connector; differences know no offset."""
        found = self._hierarchy.unit_at(port)
        return replace(found, offset=Fraction(0)) if found is not None and is_relative else found

    def _between(
        self, source: Unit | None, target: Unit | None, connection: SspConnection
    ) -> Linear:
        try:
            return between(source, target)
        except ValueError as error:
            raise InputError(
                f"a connection cannot carry a value: {error}.",
                place(self._structure.file, connection.element),
            ) from None

    def _units_differ(self, source: Port, target: Port) -> bool:
        """Whether there is anything to ignore."""
        ends = [
            (path, self._hierarchy.variable(path, connector))
            for path, connector in (source, target)
        ]
        units = [self._hierarchy.unit(path, variable) for path, variable in ends]
        relative = [variable.is_relative for _, variable in ends]
        return conversion(*units) != (1.0, 0.0) or relative[0] != relative[1]

    def _component(self, path: Path) -> dict[str, Any]:
        hierarchy = self._hierarchy
        component, values = hierarchy.components[path], self._values.of(path)
        own = {key: plain(text) for key, text in component.own.items()}
        written: dict[str, Any] = {"fmu": str(component.source.absolute())}
        if "rate" not in own:
            written["rate"] = format_exact(1 / self._step(path))
        written |= own
        for section in ("parameters", "start"):
            named = {
                name: value
                for name, value in values.items()
                if (hierarchy.variable(path, name).causality in _SETTABLE)
                is (section == "parameters")
            }
            if named:
                written[section] = named
        return written

    def _step(self, path: Path) -> Fraction:
        text = self._hierarchy.components[path].step or self._structure.step
        if text is not None:
            return self._written_step(path, text)
        step = self._hierarchy.fmus[path].step_size
        if step is None:
            self._notes.append(
                f"nobody says how long the steps of {'.'.join(path)} are: {float(DEFAULT_STEP):g} s"
            )
            return DEFAULT_STEP
        return step

    def _written_step(self, path: Path, text: str) -> Fraction:
        try:
            found = decimal(text)
        except ValueError:
            found = Fraction(0)
        if found <= 0:
            element = self._hierarchy.components[path].element
            raise InputError(
                f"the step of {'.'.join(path)} is '{text}', which is no time above 0.",
                place(self._structure.file, element),
            )
        return found


def to_scenario(
    structure: SspStructure,
    stop_time: Fraction | None,
    notes: list[str],
    start_time: Fraction | None = None,
) -> dict[str, Any]:
    """The document of a scenario that computes what the structure describes.

    The times (s) take the place of the structure's; ``notes`` gets what is worth telling.

    Raises:
        InputError: something of it cannot be used here.
    """
    return _Importer(structure, notes).document(stop_time, start_time)
