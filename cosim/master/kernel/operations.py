"""From the actions of a plan to the operations of the kernel, each with its number."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.clock import Clock
from cosim.master.assembly.layout import Layout
from cosim.master.assembly.plan import Act, Action, Part
from cosim.master.assembly.wiring import Wiring
from cosim.master.channels.texts import CarriedTexts
from cosim.master.components.interface import size_of
from cosim.master.components.playing import rows_to_play
from cosim.master.kernel.accesses import Accesses, Native
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.copies import Copies
from cosim.master.kernel.structures import InstanceStruct, OperationStruct
from cosim.master.kernel.turning import Turning
from cosim.master.kernel.written import Accessor, Call, WrittenOperation, with_table

_CALLS = {Act.READ: "read", Act.GET: "evaluate", Act.WRITE: "write", Act.STEP: "step"}


class Operations:
    """The operations of a program; owns the memory that they point to."""

    def __init__(
        self,
        parts: Mapping[str, Part],
        wiring: Wiring,
        layout: Layout,
        clock: Clock,
        cells: NDArray[np.int64],
        *,
        turning: Turning,
        texts: CarriedTexts,
        natives: Mapping[str, Native],
        recorded: tuple[Sequence[Sequence[int]], Sequence[Sequence[int]]],
    ) -> None:
        """``recorded`` holds the recorded cells of each group, and those of its texts."""
        self.all: list[OperationStruct] = []
        self.actions: list[Action] = []
        """The action behind each operation."""
        self.calls: dict[int, Call] = {}
        """The call-out behind an operation."""
        self.accessors: list[tuple[int, Accessor]] = []
        """The number of each operation that sets or gets, and whose accessor it calls."""
        self.steps: dict[str, int] = {}
        """The number of an operation that steps each FMU."""
        self.instances = {name: number for number, name in enumerate(sorted(natives))}
        """The number of each FMU among the kernel's instances."""
        self.accesses = Accesses(parts, layout, cells, natives, self.instances)
        self._copies = Copies(wiring, layout)
        self._parts = parts
        self._wiring = wiring
        self._layout = layout
        self._clock = clock
        self._cells = cells
        self._turning = turning
        self._texts = texts
        self._natives = natives
        self._columns, self._text_columns = recorded
        self._places = {name: place for place, name in enumerate(sorted(parts))}
        self._memory: list[object] = []

    def add(self, written: WrittenOperation, action: Action) -> int:
        """The number of an operation, from now on."""
        number = len(self.all)
        self.all.append(written.operation)
        self.actions.append(action)
        self._memory.append(written.memory)
        if written.call is not None:
            self.calls[number] = written.call
        if written.accessor is not None:
            self.accessors.append((number, written.accessor))
        return number

    def point_to(self, instances: int) -> None:
        """Finish what was written, with the address of the kernel's instances.

        The copies before sets of reals come to lie side by side, in the order of the sets.
        """
        for operation in self.all:
            if operation.version:
                operation.instance = instances + ctypes.sizeof(InstanceStruct) * operation.owner
        sets = [each for each in self.all if each.kind == OperationKind.SET_FLOAT64]
        copies = np.zeros((sum(each.copy_count for each in sets) + 1, 2), dtype=np.int32)
        self._memory.append(copies)
        place = copies.ctypes.data
        for operation in sets:
            length = copies.strides[0] * operation.copy_count
            ctypes.memmove(place, operation.table, length)
            operation.table = place
            place += length

    def numbers_of(self, action: Action, *, is_initial: bool = False) -> list[int]:
        """Write the operations of an action.

        ``is_initial``: in initialisation mode, in which inputs of events are set like all others.
        """
        unit = action.unit
        if isinstance(unit, int):
            written = self._of_bundle(action, unit)
        elif action.act is Act.SET:
            written = self._sets(unit, action.names, is_initial=is_initial)
        elif action.act is Act.TUNE:
            written = self._tunes(unit, action.names)
        elif unit in self._natives:
            gets = action.act is Act.GET
            written = self._gets(unit, action.names) if gets else self._step(unit)
        elif action.act is Act.GET and self._parts[unit].played is not None:
            written = self._plays(unit, action.names)
        else:
            written = self._component_call(unit, _CALLS[action.act])
        numbers = [self.add(each, action) for each in written]
        if action.act is Act.STEP and unit in self._natives:
            self.steps[str(unit)] = numbers[0]
        return numbers

    def _sets(
        self, unit: str, names: Iterable[str | int], *, is_initial: bool
    ) -> Iterable[WrittenOperation]:
        set_always = [
            name
            for name in names
            if (unit, name) not in self._turning.knobs
            and not self._waits(unit, str(name), is_initial=is_initial)
        ]
        copies = self._copies.into(unit, names)
        if unit not in self._natives or not set_always:
            yield from copies
        else:
            yield from self.accesses.with_copies(unit, copies, set_always)
            yield from self._text_calls(unit, set_always, is_set=True)
        if unit in self._parts:
            yield from self._tunes(unit, names)

    def _gets(self, unit: str, names: Iterable[str | int]) -> Iterable[WrittenOperation]:
        variables = self._parts[unit].interface.variables
        latched = [str(name) for name in names if (unit, name) in self._layout.latched]
        read = [name for name in names if (unit, name) not in self._layout.latched]
        sizes = ((name, size_of(variables[name])) for name in dict.fromkeys(latched))
        yield from self._copies.latched(unit, sizes)
        yield from self.accesses.of(unit, read, is_set=False)
        yield from self._text_calls(unit, read, is_set=False)

    def _step(self, unit: str) -> Iterable[WrittenOperation]:
        fmu = self._natives[unit]
        is_whole = fmu.substeps == 1 and unit not in self._layout.events
        kind = OperationKind.STEP if is_whole else OperationKind.STEP_IN_PARTS
        owner = self.instances[unit]
        yield WrittenOperation(OperationStruct(kind=kind, owner=owner, version=fmu.version))

    def _component_call(self, unit: str, method: str) -> Iterable[WrittenOperation]:
        if self._parts[unit].overrides(method):
            yield self._call(Call(unit, method), self._places[unit])

    def _call(self, call: Call, owner: int = 0) -> WrittenOperation:
        return WrittenOperation(OperationStruct(kind=OperationKind.CALL, owner=owner), call=call)

    def _plays(self, unit: str, names: Iterable[str | int]) -> Iterable[WrittenOperation]:
        """One operation for each run of neighbouring cells."""
        part = self._parts[unit]
        assert part.played is not None
        outputs = [n for n, v in part.interface.variables.items() if v.causality == "output"]
        cells = sorted((self._layout.cells[unit, str(name)], str(name)) for name in names)
        for _, run in groupby(enumerate(cells), lambda item: item[1][0] - item[0]):
            members = [cell for _, cell in run]
            columns = [outputs.index(name) for _, name in members]
            rows = rows_to_play(part.played, columns, self._clock, part.period)
            operation = OperationStruct(
                kind=OperationKind.PLAY,
                owner=self._places[unit],
                cells=self._cells.ctypes.data + 8 * members[0][0],
                table=ctypes.addressof(rows.struct),
            )
            yield WrittenOperation(operation, (rows,))

    def _waits(self, unit: str, name: str, *, is_initial: bool) -> bool:
        """Whether an input is not set where inputs are, but when an event takes place."""
        facts = self._parts[unit].interface.events if unit in self._parts else None
        if facts is None:
            return False
        if name in facts.clock_names():
            return True
        variable = self._parts[unit].interface.variables[name]
        return not is_initial and facts.is_event_input(variable)

    def _of_bundle(self, action: Action, number: int) -> Iterable[WrittenOperation]:
        if action.act is Act.DELIVER:
            yield WrittenOperation(OperationStruct(kind=OperationKind.DELIVER, owner=number))
        elif action.act is Act.SEND:
            yield WrittenOperation(OperationStruct(kind=OperationKind.SEND, owner=number))
        elif action.act is Act.RECORD:
            yield with_table(OperationKind.RECORD, self._columns[number], owner=number)
            if number < len(self._text_columns) and self._text_columns[number]:
                records = self._texts.recorder(number, self._text_columns[number])
                yield self._call(Call("record", "texts", records=records))
        else:
            entries = self._wiring.bundles[number].entries
            pairs = [
                (self._layout.of(entries[index].source), self._layout.held[number] + index)
                for index in map(int, action.names)
            ]
            kind = OperationKind.COPY if action.act is Act.HOLD else OperationKind.SAMPLE
            yield with_table(kind, pairs, owner=number)

    def _text_calls(
        self, unit: str, names: Iterable[str | int], *, is_set: bool
    ) -> Iterable[WrittenOperation]:
        """A call-out for each type of text among the variables."""
        fmu = self._natives[unit]
        make = self._texts.setter if is_set else self._texts.getter
        for passing in self._texts.passings(unit, [str(name) for name in names]):
            call = Call(unit, f"{'set' if is_set else 'get'}_texts", passes=make(passing, fmu))
            yield self._call(call, self._places[unit])

    def _tunes(self, unit: str, names: Iterable[str | int]) -> Iterable[WrittenOperation]:
        """One operation for each of the variables that may be turned."""
        for name in map(str, names):
            if (unit, name) not in self._turning.knobs:
                continue
            is_channel = unit not in self._parts
            native, owner = self._natives.get(unit), self.instances.get(unit, 0)
            kind = self._turning.knobs[unit, name].variable.type
            yield WrittenOperation(
                self._turning.operation((unit, name), native, owner, by_call=is_channel),
                call=Call(unit, name.partition(".")[0], is_channel=True) if is_channel else None,
                accessor=Accessor(unit, kind, True) if native is not None else None,
            )
