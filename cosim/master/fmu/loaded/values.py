"""The values that an FMU is given before it runs: structural parameters, others, start values."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any, cast

from cosim.base.component import Causality, VariableType
from cosim.base.errors import InputError
from cosim.master.fmu.binding import OK, WARNING, Assignment
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.fmi2 import Fmi2
from cosim.master.fmu.fmi3 import Fmi3
from cosim.master.fmu.loaded.conduct import Conduct
from cosim.master.fmu.loaded.residence import Residence


class GivenValues:
    """Those of one instance."""

    def __init__(
        self,
        component: str,
        description: FmuDescription,
        residence: Residence,
        conduct: Conduct,
    ) -> None:
        self._component = component
        self._variables = description.variables
        self._references = description.references
        self._residence = residence
        self._conduct = conduct
        self._structural = frozenset(
            name
            for name, variable in description.variables.items()
            if variable.causality is Causality.STRUCTURAL_PARAMETER
        )

    @property
    def are_structural(self) -> bool:
        """Whether there are structural parameters, which FMI 3's configuration mode sets."""
        return bool(self._structural)

    def configure(self, values: Mapping[str, list[Any]]) -> None:
        """Set structural parameters in FMI 3's configuration mode.

        Raises:
            InputError: the FMU refuses one, or all of them together.
            RunError: it failed for good.
        """
        if not self._structural:
            return
        structural = {n: e for n, e in values.items() if n in self._structural}
        if not structural:
            return
        self._conduct.check_start(
            "enter configuration mode", self._residence.bound.enter_configuration()
        )
        self._set_each(structural)
        self._conduct.check_start(
            "leave configuration mode", self._residence.bound.exit_configuration()
        )

    def set(self, values: Mapping[str, list[Any]]) -> None:
        """Set parameters or start values before initialisation; ``configure`` comes first.

        Raises:
            InputError: the FMU refuses one.
            RunError: it failed for good.
        """
        self._set_each({n: e for n, e in values.items() if n not in self._structural})

    def _set_each(self, values: Mapping[str, list[Any]]) -> None:
        for name, elements in values.items():
            kind = self._variables[name].type
            try:
                status = self._residence.bound.set_values(kind, self._references[name], elements)
            except (ValueError, TypeError, OverflowError, ctypes.ArgumentError) as error:
                raise InputError(
                    f"{self._component}: {name} = {_show(elements)} does not fit its type, {kind}"
                ) from error
            if status not in {OK, WARNING}:
                self._conduct.refuse_value(f"{name} = {_show(elements)}", status)

    def assignments(self, values: Mapping[str, list[Any]]) -> list[tuple[int, Assignment]]:
        """The functions and their arguments that set all values, one for each type.

        Raises:
            ValueError, TypeError, OverflowError, ctypes.ArgumentError: one does not fit its type.
        """
        bound = cast("Fmi2 | Fmi3", self._residence.bound)
        of_type: dict[VariableType, list[str]] = {}
        for name in values:
            of_type.setdefault(self._variables[name].type, []).append(name)
        found: list[tuple[int, Assignment]] = []
        for kind, names in of_type.items():
            references = [self._references[name] for name in names]
            elements = [element for name in names for element in values[name]]
            ready = bound.assignment(kind, references, elements)
            found.append((bound.address(ready.function), ready))
        return found


def _show(elements: list[Any]) -> str:
    return repr(elements[0]) if len(elements) == 1 else repr(elements)
