"""The values of a system's parameters: later bindings win, and outer ones over inner ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.ssp.conversions import Linear
from cosim.ssp.hierarchy import Hierarchy, Path, Port
from cosim.ssp.parameters import GivenValue
from cosim.ssp.structure import SspSystem


class BoundValues:
    """By component and variable; ``notes`` gets what is worth telling."""

    def __init__(self, hierarchy: Hierarchy, notes: list[str]) -> None:
        self._hierarchy = hierarchy
        self._notes = notes
        self._values: dict[Path, dict[str, Any]] = {}

    def of(self, path: Path) -> Mapping[str, Any]:
        """Those of a component."""
        return self._values.get(path, {})

    def bind(self, system: SspSystem, at: Path) -> None:
        """Take the bindings of a system and of all within it.

        Raises:
            InputError: a value does not fit its variable's unit.
        """
        for name, element in system.elements.items():
            path = (*at, name)
            if isinstance(element, SspSystem):
                self.bind(element, path)
                continue
            for binding in element.bindings:
                self._notes += binding.notes
                for variable, value in binding.values.items():
                    self._set(path, variable, value)
        for binding in system.bindings:
            self._notes += binding.notes
            for name, value in binding.values.items():
                targets = self._targets(system, at, name, value)
                if not targets:
                    self._notes.append(f"nothing in {system.name} has the parameter {name}")
                for path, variable, given in targets:
                    self._set(path, variable, given)

    def _targets(
        self, system: SspSystem, at: Path, name: str, given: GivenValue
    ) -> list[tuple[Path, str, GivenValue]]:
        """The components' variables that a name in a system means, and what each is given."""
        if name in system.kinds:
            return self._behind((at, name), given)
        for child in sorted(system.elements, key=len, reverse=True):
            element = system.elements[child]
            if not name.startswith(f"{child}."):
                continue
            rest, path = name[len(child) + 1 :], (*at, child)
            if isinstance(element, SspSystem):
                return self._targets(element, path, rest, given)
            return [(path, rest, given)]
        return []

    def _behind(self, port: Port, given: GivenValue) -> list[tuple[Path, str, GivenValue]]:
        found: list[tuple[Path, str, GivenValue]] = []
        here = self._in_unit(given, port)
        for target, edge in self._hierarchy.drivers.items():
            if edge.source != port:
                continue
            connection = edge.connection
            there = GivenValue(here.value, None) if connection.ignores_unit else here
            there = self._in_unit(there, target)
            there = there.through(Linear.of(connection.factor, connection.offset))
            if target[0] in self._hierarchy.components:
                found.append((*target, there))
            else:
                found += self._behind(target, there)
        return found

    def _in_unit(self, given: GivenValue, port: Port) -> GivenValue:
        path, name = port
        try:
            return given.arriving(self._hierarchy.unit_at(port))
        except ValueError as error:
            raise InputError(f"{'.'.join((*path, name))}: {error}") from None

    def _set(self, path: Path, name: str, given: GivenValue) -> None:
        try:
            variable = self._hierarchy.variable(path, name)
        except InputError as error:
            self._notes.append(f"a parameter set: {error.message}")
            return
        if variable.name in self._hierarchy.fmus[path].calculated:
            self._notes.append(
                f"{'.'.join((*path, name))} is calculated by its FMU, so the value that is given "
                "for it is left out"
            )
            return
        here = self._hierarchy.unit_at((path, name))
        if given.unit is not None and given.unit.exponents is None and given.unit != here:
            self._notes.append(
                f"{'.'.join((*path, name))}: nobody says what {given.unit.name} measures, so its "
                "number is taken as it is"
            )
        value = self._in_unit(given, (path, name)).value
        if variable.meaning is Meaning.FILE and value:
            value = str((self._hierarchy.file.parent / str(value)).absolute())
        if variable.shape and variable.name == name and not isinstance(value, list):
            value = [value]
        self._values.setdefault(path, {})[name] = value
