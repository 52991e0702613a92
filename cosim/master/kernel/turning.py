"""What is turned, as the kernel runs it: events, and an operation for each knob."""

from __future__ import annotations

import ctypes
from bisect import bisect_left
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import VariableType
from cosim.master.assembly.knobs import Knob, Name, Turn
from cosim.master.assembly.layout import Layout
from cosim.master.components.interface import size_of
from cosim.master.kernel.codes import FMI2_TYPE_CODES, TYPE_CODES, OperationKind
from cosim.master.kernel.structures import ChangeStruct, KernelStruct, KnobStruct, OperationStruct


class Settable(Protocol):
    """What is needed of a loaded FMU to set its parameters."""

    version: int

    def accessor(self, kind: VariableType, *, is_set: bool) -> int:
        """Address of the set or get function of a type."""
        ...

    def reference(self, variable: str) -> int:
        """The value reference of a variable."""
        ...


class Turning:
    """The knobs of a program; owns the memory that their operations and events point to."""

    def __init__(
        self, knobs: Mapping[Name, Knob], layout: Layout, cells: NDArray[np.int64]
    ) -> None:
        self.knobs = knobs
        self.asked: deque[tuple[Name, tuple[Any, ...]]] = deque()
        """What is to be turned before the next tick; any thread may append."""
        self.by_hand: list[Turn] = []
        """What was turned so, and when."""
        self._layout, self._cells = layout, cells
        self._events: Any = (ChangeStruct * 1)()
        self._ticks: list[int] = []
        self._keep: list[Any] = []

    def fill_start_values(self) -> None:
        """Every knob stands where the scenario says."""
        for name, knob in self.knobs.items():
            for first in (self._layout.cells[name], self._layout.wanted[name]):
                self._fill(first, knob, knob.start)

    def rewind(self, knobs: Mapping[Name, Knob]) -> None:
        """Nothing was turned yet; ``knobs`` may stand elsewhere at the start."""
        self.knobs = knobs
        self.asked.clear()
        self.by_hand.clear()

    def write_events(self, kernel: KernelStruct, turns: Sequence[Turn]) -> None:
        """What the kernel turns by itself, in the order of the ticks."""
        if not turns and not self._ticks and kernel.changes:
            return
        changes = [
            (turn.tick, self._layout.wanted[turn.name] + index, bits)
            for turn in turns
            for index, bits in enumerate(self._bits(turn.name, turn.elements))
        ]
        self._ticks = [tick for tick, _, _ in changes]
        self._events = (ChangeStruct * max(len(changes), 1))(*changes)
        kernel.changes = ctypes.addressof(self._events)
        kernel.change_count, kernel.next_change = len(changes), 0

    def go_on(self, kernel: KernelStruct, tick: int) -> None:
        """A run goes on at a tick: the events before it have happened."""
        kernel.next_change = bisect_left(self._ticks, tick)

    def turn_as_asked(self, tick: int) -> None:
        """Before a tick: what was asked for is wanted from now on."""
        while self.asked:
            name, elements = self.asked.popleft()
            self._fill(self._layout.wanted[name], self.knobs[name], elements)
            self.by_hand.append(Turn(tick, name, elements))

    def operation(
        self, name: Name, native: Settable | None, owner: int, *, by_call: bool = False
    ) -> OperationStruct:
        """What brings a knob into force: in an FMU, in the cells of a Python component, by a call.

        ``owner`` is the number of the FMU's instance.
        """
        knob = self.knobs[name]
        kind, count = knob.variable.type, size_of(knob.variable)
        items = np.array(list((knob.variable.items or {}).values()), dtype=np.int64)
        table = KnobStruct(
            self._address(self._layout.wanted[name]),
            knob.minimum,
            knob.maximum,
            kind.is_float,
            by_call,
            items.ctypes.data,
            len(items),
        )
        self._keep += [table, items]
        operation = OperationStruct(
            kind=OperationKind.TUNE,
            owner=owner,
            cells=self._address(self._layout.cells[name]),
            cell_count=count,
            table=ctypes.addressof(table),
        )
        if native is not None:
            references = np.array([native.reference(name[1])], np.uint32)
            scratch = np.zeros(count, dtype=np.int64)
            self._keep += [references, scratch]
            operation.type = (FMI2_TYPE_CODES if native.version == 2 else TYPE_CODES)[kind]
            operation.version = native.version
            operation.function = native.accessor(kind, is_set=True)
            operation.references = references.ctypes.data
            operation.reference_count = 1
            operation.scratch = scratch.ctypes.data
        return operation

    def _address(self, cell: int) -> int:
        return self._cells.ctypes.data + 8 * cell

    def _fill(self, first: int, knob: Knob, elements: Sequence[Any]) -> None:
        cells = self._cells[first : first + len(elements)]
        (cells.view(np.float64) if knob.variable.type.is_float else cells)[:] = elements

    def _bits(self, name: Name, elements: Sequence[Any]) -> list[int]:
        kind = np.float64 if self.knobs[name].variable.type.is_float else np.int64
        return np.array(elements, dtype=kind).view(np.int64).tolist()
