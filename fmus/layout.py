"""Where each element of a model's variables lies: slots, element names and dependencies.

The slot is the FMI value reference and the offset (in 8 bytes) into the C struct ``Variables``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property

from cosim.base.meaning import Meaning, Slot
from fmus.table import Enumeration, Group, Model, ModelVariable, Numbered

STRING_SLOTS = 64
"""Slots that one string takes: 511 bytes and the terminating zero."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A variable at its path from the model's root, ``finger_1.joint_angle``; first at ``slot``."""

    path: str
    group: str
    variable: ModelVariable
    slot: int
    belongs_to: Slot


@dataclass(frozen=True, slots=True)
class SlotElement:
    """One scalar: ``index`` counts from 0 within the array; ``name`` carries ``[index + 1]``."""

    name: str
    variable: ModelVariable
    slot: int
    index: int
    belongs_to: Slot

    @property
    def meaning(self) -> Meaning | None:
        """The meaning of this element."""
        meaning = self.variable.meaning
        return meaning[self.index] if isinstance(meaning, tuple) else meaning

    @property
    def start(self) -> float | int | bool | str | None:
        """The start value of this element."""
        start = self.variable.start
        return start[self.index] if isinstance(start, tuple) else start


class SlotLayout:
    """The variables of a model in slot order.

    Raises:
        ValueError: the table contradicts itself; the message names the variable.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.placed: list[Placed] = []
        self.slots = self._place(model.variables, "", 0, Slot())
        self._check()

    def _place(
        self, members: tuple[ModelVariable | Group, ...], prefix: str, slot: int, belongs_to: Slot
    ) -> int:
        for member in members:
            if isinstance(member, ModelVariable):
                path = f"{prefix}{member.name}"
                own = Slot(member.peer or belongs_to.peer, member.finger or belongs_to.finger)
                self.placed.append(Placed(path, prefix.rstrip("."), member, slot, own))
                slot += (member.size or 1) * (STRING_SLOTS if member.type == "string" else 1)
                continue
            names = (
                [member.name]
                if member.count is None
                else [f"{member.name}_{number}" for number in range(1, member.count + 1)]
            )
            for number, name in enumerate(names, start=1):
                inner = _numbered(belongs_to, member.numbers, number)
                slot = self._place(member.members, f"{prefix}{name}.", slot, inner)
        return slot

    @cached_property
    def elements(self) -> list[SlotElement]:
        """Every scalar element in slot order."""
        return [element for placed in self.placed for element in elements_of(placed)]

    @cached_property
    def enumerations(self) -> list[Enumeration]:
        """Each enumeration once, in order of first use."""
        found: dict[str, Enumeration] = {}
        for placed in self.placed:
            if placed.variable.enumeration is not None:
                found.setdefault(placed.variable.enumeration.name, placed.variable.enumeration)
        return list(found.values())

    @cached_property
    def units(self) -> list[str]:
        """Each unit once, in order of first use."""
        return list(dict.fromkeys(p.variable.unit for p in self.placed if p.variable.unit))

    def matching(self, patterns: tuple[str, ...], group: str) -> Iterator[Placed]:
        """The inputs that ``depends_on`` patterns of a variable in ``group`` name."""
        resolved = [pattern.replace("{group}", group) for pattern in patterns]
        for placed in self.placed:
            if placed.variable.causality == "input" and any(
                fnmatchcase(placed.path, pattern) for pattern in resolved
            ):
                yield placed

    def find(self, path: str) -> Placed:
        """The variable at ``path``.

        Raises:
            ValueError: there is none.
        """
        for placed in self.placed:
            if placed.path == path:
                return placed
        raise ValueError(f"model {self.model.name} has no variable '{path}'.")

    def _check(self) -> None:
        problems: list[str] = []
        paths = [placed.path for placed in self.placed]
        problems += [
            f"'{path}' is there twice" for path in {p for p in paths if paths.count(p) > 1}
        ]
        for placed in self.placed:
            variable = placed.variable
            problems += [f"'{placed.path}' {problem}" for problem in _problems(variable)]
            for pattern in variable.depends_on:
                if not any(self.matching((pattern,), placed.group)):
                    problems.append(f"'{placed.path}' depends on '{pattern}', which is no input")
        for terminal in self.model.terminals:
            problems += [
                f"terminal '{terminal.name}' has a member '{path}', which is no variable"
                for path in terminal.members.values()
                if path not in paths
            ]
        if problems:
            raise ValueError(f"Model {self.model.name}: " + "; ".join(problems) + ".")


def elements_of(placed: Placed) -> list[SlotElement]:
    """The scalar elements of one variable."""
    variable, width = placed.variable, STRING_SLOTS if placed.variable.type == "string" else 1
    if variable.size is None:
        return [SlotElement(placed.path, variable, placed.slot, 0, placed.belongs_to)]
    return [
        SlotElement(
            f"{placed.path}[{index + 1}]",
            variable,
            placed.slot + width * index,
            index,
            _numbered(placed.belongs_to, variable.each, index + 1),
        )
        for index in range(variable.size)
    ]


def _numbered(slot: Slot, what: Numbered | None, number: int) -> Slot:
    """``slot`` with the number of what is numbered, if anything is."""
    return slot if what is None else replace(slot, **{what: number})


def _problems(variable: ModelVariable) -> Iterator[str]:
    settable = variable.causality in {"parameter", "input"}
    if settable and variable.start is None and variable.type != "string":
        yield "needs a start value"
    if not settable and variable.start is not None:
        yield "is computed and cannot have a start value"
    if isinstance(variable.start, tuple) and len(variable.start) != (variable.size or 1):
        yield f"has {len(variable.start)} start values for {variable.size or 1} elements"
    if (variable.type == "enumeration") != (variable.enumeration is not None):
        yield "must have an enumeration exactly if it is of that type"
    if variable.type == "real" and variable.unit is None:
        yield "needs a unit ('1' for a pure number, '' for any)"
    if isinstance(variable.meaning, tuple) and len(variable.meaning) != variable.size:
        yield f"has {len(variable.meaning)} meanings for {variable.size or 1} elements"
    if variable.each and variable.size is None:
        yield "numbers its elements, but is no array"
    if variable.depends_on and variable.causality == "input":
        yield "is an input and depends on nothing"
