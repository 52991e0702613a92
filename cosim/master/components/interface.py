"""What a component shows to the others: variables, their elements, terminals and dependencies.

An array counts as its elements everywhere, so that an FMI 3 array and the scalars ``x[1]`` and
``x[2]`` of an archive without arrays connect to each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product
from math import prod

from cosim.base.component import Causality, Variable
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit, unit_of
from cosim.base.suggest import did_you_mean, index_hint
from cosim.master.components.clocks import EventFacts

_INDEXED = re.compile(r"(.+)\[(\d+(?:,\d+)*)\]")
_SIGNALS = {Causality.INPUT, Causality.OUTPUT, Causality.LOCAL}


@dataclass(frozen=True, slots=True)
class Element:
    """One 8-byte value: a scalar variable, or element ``index`` (from 0, row-major) of an array."""

    variable: str
    index: int


@dataclass(frozen=True, slots=True)
class Selection:
    """What a path stands for, in order: member name -> element.

    ``named`` says that members meet by name (a terminal, a group); otherwise they meet by place.
    """

    kind: str
    members: Mapping[str, Element]
    named: bool


@dataclass(slots=True)
class Interface:
    """A component as the connections see it.

    ``dependencies`` holds, for each output, the inputs it depends on directly; it is only used
    where ``feedthrough`` is true. ``terminals`` maps each terminal to its members: member name ->
    variable name.
    """

    component: str
    variables: Mapping[str, Variable]
    feedthrough: bool
    dependencies: Mapping[str, Sequence[str]] = field(default_factory=dict[str, Sequence[str]])
    initial_dependencies: Mapping[str, Sequence[str]] = field(
        default_factory=dict[str, Sequence[str]]
    )
    terminals: Mapping[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])
    units: Mapping[str, Unit] = field(default_factory=dict[str, Unit])
    skipped: frozenset[str] = frozenset()
    """Variables of the FMU that have values in event mode alone."""
    events: EventFacts | None = None
    """What happens at events, where an FMU's event mode is used."""
    knobs: set[str] = field(default_factory=set[str], init=False)
    """The tunable parameters that may be turned in this run: connected and recorded as inputs."""
    elements: dict[str, Element] = field(init=False)

    def __post_init__(self) -> None:
        self.elements = {
            name: element
            for variable in self.variables.values()
            if has_cells(variable)
            for name, element in variable_elements(variable)
        }

    def make_knob(self, variable: str) -> None:
        """A tunable parameter may be turned."""
        self.knobs.add(variable)
        self.elements.update(variable_elements(self.variables[variable]))

    def lives_in_cells(self, variable: str) -> bool:
        """Whether the variable's values live in cells: a signal, or a parameter that is turned."""
        return variable in self.knobs or has_cells(self.variables[variable])

    def outputs_depend_on(self, output: str, *, initially: bool = False) -> Sequence[str]:
        """The inputs that an output depends on within a tick (or also in initialisation mode)."""
        if not self.feedthrough:
            return ()
        # What depends on which parameter no description says (FMI 3.0, section 2.4.8): all do.
        direct = (*self.dependencies.get(output, ()), *sorted(self.knobs))
        if not initially:
            return direct
        return tuple(dict.fromkeys((*direct, *self.initial_dependencies.get(output, ()))))

    def unit(self, variable: str) -> Unit | None:
        """The unit of a variable, if it has one."""
        described = self.variables[variable]
        if not described.unit:
            return None
        unit = self.units.get(described.unit) or unit_of(described.unit)
        return replace(unit, offset=Fraction(0)) if described.is_relative else unit

    def select(self, path: str) -> Selection:
        """What ``path`` stands for: a variable, an array, a terminal or a dotted group.

        Raises:
            InputError: there is nothing of that name.
        """
        variable = self.variables.get(path)
        if variable is not None and not self.lives_in_cells(path) and path in self.terminals:
            variable = None  # a parameter beside a terminal of the same name
        if variable is not None and not self.lives_in_cells(path):
            raise InputError(
                f"{self.component}.{path} is of causality '{variable.causality}'; only inputs, "
                "outputs, local variables and tunable parameters that are numbers, booleans or "
                "enumerations can be connected or recorded"
            )
        if variable is not None:
            members = {
                name.removeprefix(path): element for name, element in variable_elements(variable)
            }
            return Selection("array" if variable.shape else "variable", members, named=False)
        if path in self.elements:
            return Selection("variable", {"": self.elements[path]}, named=False)
        array = {
            match.group(2): self.elements[name]
            for name in self.elements
            if (match := _INDEXED.fullmatch(name)) and match.group(1) == path
        }
        if array:
            ordered = sorted(array, key=lambda text: [int(i) for i in text.split(",")])
            return Selection("array", {f"[{i}]": array[i] for i in ordered}, named=False)
        if path in self.terminals:
            return Selection("terminal", dict(self._terminal(path)), named=True)
        prefix = f"{path}."
        group = {
            name.removeprefix(prefix): element
            for name, element in self.elements.items()
            if name.startswith(prefix)
        }
        if group:
            return Selection("group", group, named=True)
        if path in self.skipped:
            raise InputError(
                f"{self.component}.{path} belongs to a clock, which ticks in event mode alone, and "
                "that is not used; it cannot be connected or recorded"
            )
        raise InputError(f"{self.component} has no variable '{path}'.{self.suggest(path)}")

    def suggest(self, path: str) -> str:
        """The nearest names, as a sentence that follows an error."""
        if counted := index_hint(path):
            return counted
        bases = {name.split("[")[0] for name in self.elements}
        return did_you_mean(path, {*self.elements, *bases, *self.terminals})

    def element_name(self, element: Element) -> str:
        """``path`` or ``path[i]`` of an element."""
        variable = self.variables[element.variable]
        for name, candidate in variable_elements(variable):
            if candidate == element:
                return name
        raise KeyError(element)

    def _terminal(self, terminal: str) -> Iterator[tuple[str, Element]]:
        for member, name in self.terminals[terminal].items():
            variable = self.variables.get(name)
            if variable is None or not has_cells(variable):
                continue
            for full, element in variable_elements(variable):
                yield member + full.removeprefix(name), element


def has_cells(variable: Variable) -> bool:
    """Whether the variable's values live in cells: a signal."""
    return variable.causality in _SIGNALS


def is_tunable(variable: Variable) -> bool:
    """Whether it is a parameter that may change between two steps (FMI 3.0, section 2.4.7.4)."""
    return (
        variable.causality is Causality.PARAMETER
        and variable.variability == "tunable"
        and not variable.type.is_text
    )


def size_of(variable: Variable) -> int:
    """The number of elements."""
    return prod(variable.shape)


def variable_elements(variable: Variable) -> Iterator[tuple[str, Element]]:
    """The elements of a variable with their names; indices in names count from 1 (FMI)."""
    if not variable.shape:
        yield variable.name, Element(variable.name, 0)
        return
    ranges = (range(1, size + 1) for size in variable.shape)
    for number, index in enumerate(product(*ranges)):
        yield f"{variable.name}[{','.join(map(str, index))}]", Element(variable.name, number)
