"""From a system structure to the document of a scenario."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from cosim.base.component import Causality
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import format_exact
from cosim.base.quantities.units import conversion
from cosim.ssp.bindings import BoundValues
from cosim.ssp.hierarchy import DrivenBy, Hierarchy, Path, Port, plain
from cosim.ssp.structure import SspStructure
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

    def document(self, stop_time: Fraction | None) -> dict[str, Any]:
        own = dict(self._structure.own)
        title = own.pop("title", self._structure.title)
        start = start_of(self._structure, own)
        times = {"start_time": format_exact(start)} if start else {}
        duration = duration_of(self._structure, own, start, stop_time)
        rest = {"cohaptic": 1, "title": title, **times, "duration": duration, **own}
        names = self._hierarchy.names.items()
        return rest | {
            "components": {name: self._component(path) for path, name in names},
            "connections": [*self._connections(), *own.get("connections", [])],
        }

    def _connections(self) -> list[dict[str, Any]]:
        hierarchy, found = self._hierarchy, list[dict[str, Any]]()
        for (path, connector), edge in hierarchy.drivers.items():
            if path not in hierarchy.components:
                continue
            factor, offset, ignores, own = 1.0, 0.0, False, dict[str, str]()
            source: Port = (path, connector)
            step: DrivenBy | None = edge
            while step is not None:
                connection = step.connection
                factor, offset = factor * connection.factor, factor * connection.offset + offset
                ignores = ignores or connection.ignores_unit
                own |= connection.own
                source = step.source
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
            return Fraction(text)
        step = self._hierarchy.fmus[path].step_size
        if step is None:
            self._notes.append(
                f"nobody says how long the steps of {'.'.join(path)} are: {float(DEFAULT_STEP):g} s"
            )
            return DEFAULT_STEP
        return step


def to_scenario(
    structure: SspStructure, stop_time: Fraction | None, notes: list[str]
) -> dict[str, Any]:
    """The document of a scenario that computes what the structure describes.

    ``stop_time`` (s) takes the place of the structure's; ``notes`` gets what is worth telling.

    Raises:
        InputError: something of it cannot be used here.
    """
    return _Importer(structure, notes).document(stop_time)
