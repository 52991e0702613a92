"""Operations that set and get the variables of FMUs, as many in one call as lie side by side."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Variable, VariableType
from cosim.master.assembly.layout import Layout
from cosim.master.assembly.plan import Part
from cosim.master.channels.texts import Speaking
from cosim.master.components.interface import size_of
from cosim.master.kernel.codes import FMI2_TYPE_CODES, TYPE_CODES, OperationKind
from cosim.master.kernel.structures import OperationStruct
from cosim.master.kernel.written import Accessor, WrittenOperation


class Native(Speaking, Protocol):
    """What the program needs of a loaded FMU."""

    version: int
    substeps: int
    is_trusted: bool
    """Whether no call changes how the processor computes."""

    @property
    def events(self) -> list[int]:
        """Addresses of the functions of event mode; none where it is not used."""
        ...

    @property
    def instance(self) -> int:
        """Address of the instance."""
        ...

    @property
    def do_step(self) -> int:
        """Address of ``fmi2DoStep`` or ``fmi3DoStep``."""
        ...

    def accessor(self, kind: VariableType, *, is_set: bool) -> int:
        """Address of the set or get function of a type."""
        ...

    def reference(self, variable: str) -> int:
        """The value reference of a variable."""
        ...


class Accesses:
    """Of all FMUs of a program; ``numbers`` are theirs among the kernel's instances."""

    def __init__(
        self,
        parts: Mapping[str, Part],
        layout: Layout,
        cells: NDArray[np.int64],
        natives: Mapping[str, Native],
        numbers: Mapping[str, int],
    ) -> None:
        self._parts = parts
        self._layout = layout
        self._cells = cells
        self._natives = natives
        self._numbers = numbers

    def of(
        self, unit: str, names: Iterable[str | int], *, is_set: bool
    ) -> Iterable[WrittenOperation]:
        """One operation for each run of neighbouring cells of one type; texts are passed over."""
        variables = self._parts[unit].interface.variables
        native = self._natives[unit]
        ordered = sorted(
            (self._layout.cells[unit, str(name)], str(name))
            for name in names
            if not variables[str(name)].type.is_text
        )
        begins: list[int] = []
        expected: tuple[VariableType, int] | None = None
        for first, name in ordered:
            kind = variables[name].type
            if expected != (kind, first):
                begins.append(first)
            expected = (kind, first + size_of(variables[name]))
        codes = FMI2_TYPE_CODES if native.version == 2 else TYPE_CODES
        for _, run in groupby(ordered, lambda item: bisect_right(begins, item[0])):
            members = list(run)
            described = [variables[name] for _, name in members]
            kind = described[0].type
            count = sum(map(size_of, described))
            if not count:  # arrays without elements
                continue
            references = np.array([native.reference(name) for _, name in members], np.uint32)
            scratch = np.zeros(count, dtype=np.int64)
            items = _items(described) if is_set else None
            operation = OperationStruct(
                kind=_kind(kind, is_set=is_set),
                owner=self._numbers[unit],
                type=codes[kind],
                version=native.version,
                function=native.accessor(kind, is_set=is_set),
                references=references.ctypes.data,
                reference_count=len(references),
                cells=self._cells.ctypes.data + 8 * members[0][0],
                cell_count=count,
                scratch=scratch.ctypes.data,
                table=0 if items is None else items[0].ctypes.data,
            )
            memory = references, scratch, items
            yield WrittenOperation(operation, memory, accessor=Accessor(unit, kind, is_set))

    def with_copies(
        self, unit: str, copies: Iterable[WrittenOperation], names: Sequence[str | int]
    ) -> Iterable[WrittenOperation]:
        """Set inputs after ``copies`` into them.

        Plain copies alone, before reals are set, are made by the operation that sets them.
        """
        before = list(copies)
        first = min(map(str, names), key=lambda name: self._layout.cells[unit, name])
        is_real = self._parts[unit].interface.variables[first].type is VariableType.FLOAT64
        if not is_real or [each.operation.kind for each in before] != [OperationKind.COPY]:
            yield from before
            before = []
        for written in self.of(unit, names, is_set=True):
            memory = written.memory
            for copy in before:
                written.operation.table = copy.operation.table
                written.operation.copy_count = copy.operation.cell_count
                memory += copy.memory
            before = []
            yield written._replace(memory=memory)


def _kind(kind: VariableType, *, is_set: bool) -> OperationKind:
    is_direct = kind is VariableType.FLOAT64
    if is_set:
        return OperationKind.SET_FLOAT64 if is_direct else OperationKind.SET
    return OperationKind.GET_FLOAT64 if is_direct else OperationKind.GET


def _items(variables: Sequence[Variable]) -> tuple[NDArray[np.int64], ...] | None:
    """What each element of enumerations may be, and the memory of it; ``None`` for other types.

    Of the first array each row has the address and the number of an element's values.
    """
    if not all(variable.items for variable in variables):
        return None
    values = [
        np.array(list((variable.items or {}).values()), dtype=np.int64) for variable in variables
    ]
    rows = [
        (own.ctypes.data, len(own))
        for variable, own in zip(variables, values, strict=True)
        for _ in range(size_of(variable))
    ]
    return np.array(rows, dtype=np.int64), *values
