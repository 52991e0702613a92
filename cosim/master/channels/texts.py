"""Texts and binary values beside the kernel: it moves their numbers, this moves their bytes.

A component with such variables gets call-outs of its own, where its inputs are set, its outputs
read, or a record takes them; a run without them has none of this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Variable, VariableType
from cosim.base.recording import Sink
from cosim.base.texts import TextCells, TextTable
from cosim.master.assembly.layout import Layout
from cosim.master.assembly.plan import Part
from cosim.master.assembly.wiring import Bundle, Signal
from cosim.master.channels.packets import Packets
from cosim.master.components.interface import size_of


class Speaking(Protocol):
    """What is needed of a loaded FMU to pass its texts."""

    def get_texts(
        self, kind: VariableType, names: Sequence[str], count: int
    ) -> tuple[int, list[bytes]]:
        """The status, and the elements of variables of one type."""
        ...

    def set_texts(self, kind: VariableType, names: Sequence[str], contents: list[bytes]) -> int:
        """The status of setting all elements of variables of one type."""
        ...


@dataclass(frozen=True, slots=True)
class Passing:
    """Variables of one type of an FMU whose elements are passed together."""

    kind: VariableType
    names: tuple[str, ...]
    cells: tuple[int, ...]


class CarriedTexts:
    """The table of a run's texts, and which of its cells have numbers from there."""

    def __init__(
        self,
        parts: Mapping[str, Part],
        bundles: Sequence[Bundle],
        layout: Layout,
        cells: NDArray[np.int64],
    ) -> None:
        self._parts, self._layout, self._cells = parts, layout, cells
        self._entries = [
            [index for index, entry in enumerate(bundle.entries) if self._is_text(entry.source)]
            for bundle in bundles
        ]
        self.places = np.array(sorted(self._places()), dtype=np.int64)
        """The cells that have numbers."""
        self.packets: Packets | None = None
        self.table = TextTable(self._named)
        self._sink: Sink | None = None
        self._last: dict[tuple[int, int], int] = {}

    @property
    def are_there(self) -> bool:
        """Whether the run has any."""
        return self.places.size > 0

    def number_of(self, value: str | bytes) -> int:
        """The number of a start value, which was judged before."""
        return self.table.number(value.encode() if isinstance(value, str) else value)

    def view(self, component: str, variable: str) -> TextCells:
        """A variable's elements, with its shape; ``(1,)`` for a scalar."""
        described = self._parts[component].interface.variables[variable]
        first = self._layout.cells[component, variable]
        cells = self._cells[first : first + size_of(described)].reshape(described.shape or (1,))
        return TextCells(cells, self.table, is_binary=described.type is VariableType.BINARY)

    def passings(self, component: str, names: Sequence[str]) -> list[Passing]:
        """The text variables among ``names``, by type."""
        of_type: dict[VariableType, list[Variable]] = {}
        variables = self._parts[component].interface.variables
        for name in names:
            if variables[name].type.is_text:
                of_type.setdefault(variables[name].type, []).append(variables[name])
        return [
            Passing(
                kind,
                tuple(variable.name for variable in found),
                tuple(
                    self._layout.cells[component, variable.name] + index
                    for variable in found
                    for index in range(size_of(variable))
                ),
            )
            for kind, found in of_type.items()
        ]

    def getter(self, passing: Passing, fmu: Speaking) -> Callable[[], int]:
        """What takes an FMU's texts into their cells, and returns the status."""
        names, cells, table = passing.names, self._cells, self.table

        def get() -> int:
            status, contents = fmu.get_texts(passing.kind, names, len(passing.cells))
            for cell, content in zip(passing.cells, contents, strict=False):
                cells[cell] = table.number(content)
            return status

        return get

    def setter(self, passing: Passing, fmu: Speaking) -> Callable[[], int]:
        """What gives an FMU the texts of its cells, and returns the status."""
        names, cells, table = passing.names, self._cells, self.table

        def give() -> int:
            contents = [table.content(int(cells[cell])) for cell in passing.cells]
            return fmu.set_texts(passing.kind, names, contents)

        return give

    def record_into(self, sink: Sink | None) -> None:
        """Where changes go from now on; the first value of each counts as one."""
        self._sink = sink
        self._last.clear()

    def recorder(self, group: int, cells: Sequence[int]) -> Callable[[int], None]:
        """What hands over the texts of a record group that have changed, at a tick."""

        def record(tick: int) -> None:
            if self._sink is None:
                return
            for column, cell in enumerate(cells):
                number = int(self._cells[cell])
                if self._last.get((group, column)) != number:
                    self._last[group, column] = number
                    self._sink.put_text(group, column, tick, self.table.content(number))

        return record

    def save(self) -> dict[str, NDArray[Any]]:
        """The table as arrays, empty where the run has no texts."""
        if not self.are_there:
            return {}
        contents = self.table.save()
        return {
            "texts.numbers": np.array(list(contents), dtype=np.int64),
            "texts.sizes": np.array([len(each) for each in contents.values()], dtype=np.int64),
            "texts.bytes": np.frombuffer(b"".join(contents.values()), dtype=np.uint8),
        }

    def load(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Have the table of a snapshot.

        Raises:
            KeyError: it has none.
        """
        if self.are_there:
            self.table.load(_contents(arrays))

    def are_those_of(self, cells: NDArray[np.int64], arrays: Mapping[str, NDArray[Any]]) -> bool:
        """Whether saved cells stand for what the cells now stand for."""
        if not self.are_there:
            return bool(np.array_equal(self._cells, cells))
        numbers = np.ones(len(cells), dtype=np.bool_)
        numbers[self.places] = False
        contents, table = _contents(arrays), self.table
        there = [contents[int(number)] for number in cells[self.places]]
        here = [table.content(int(number)) for number in self._cells[self.places]]
        return there == here and bool(np.array_equal(self._cells[numbers], cells[numbers]))

    def _named(self) -> Iterator[int]:
        yield from self._cells[self.places].tolist()
        if self.packets is None:
            return
        for number, columns in enumerate(self._entries):
            if columns:
                yield from self.packets.flying(number)[:, columns].reshape(-1).tolist()

    def _places(self) -> Iterator[int]:
        for (component, name), first in self._layout.cells.items():
            part = self._parts.get(component)
            variable = None if part is None else part.interface.variables[name]
            if variable is not None and variable.type.is_text:
                yield from range(first, first + size_of(variable))
        for number, columns in enumerate(self._entries):
            yield from (self._layout.held[number] + index for index in columns)

    def _is_text(self, source: object) -> bool:
        if not isinstance(source, Signal) or source.component not in self._parts:
            return False
        return self._parts[source.component].interface.variables[source.variable].type.is_text


def _contents(arrays: Mapping[str, NDArray[Any]]) -> dict[int, bytes]:
    content = arrays["texts.bytes"].tobytes()
    ends = np.cumsum(arrays["texts.sizes"]).tolist()
    numbers, begins = arrays["texts.numbers"].tolist(), [0, *ends]
    return {
        number: content[begin:end]
        for number, begin, end in zip(numbers, begins, ends, strict=False)
    }
