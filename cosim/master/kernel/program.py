"""From the plan to what the kernel runs: operations with addresses, in one program a due set."""

from __future__ import annotations

import ctypes
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Cells, Variable, VariableType
from cosim.master.assembly.clock import Clock
from cosim.master.assembly.knobs import Knob, Name
from cosim.master.assembly.layout import Layout
from cosim.master.assembly.plan import Act, Action, Part, Plan, due_together
from cosim.master.assembly.wiring import Wire, Wiring
from cosim.master.channels.packets import Packets
from cosim.master.channels.texts import CarriedTexts, Speaking
from cosim.master.channels.turning import TurnedChannels, dials_of
from cosim.master.components.interface import size_of
from cosim.master.components.playing import rows_to_play
from cosim.master.kernel.events import EventStructures
from cosim.master.kernel.native import library
from cosim.master.kernel.structures import (
    FMI2_TYPE_CODES,
    TYPE_CODES,
    ConversionStruct,
    InstanceStruct,
    KernelOutcome,
    KernelStruct,
    OperationKind,
    OperationStruct,
    RecordStruct,
)
from cosim.master.kernel.turning import Turning

INITIAL = 0
"""The number of the program of initialisation mode."""

_FIRST, _EVERY = 1, 2
_CAREFUL_TICKS = 64
"""For which every call of a foreign FMU is looked after; see ``sources/kernel.c``."""
_CALLS = {Act.READ: "read", Act.GET: "evaluate", Act.WRITE: "write", Act.STEP: "step"}


_RUNS = (OperationKind.SET_FLOAT64, OperationKind.GET_FLOAT64, OperationKind.STEP)
"""Kinds of which the kernel does several in one go, where they lie side by side."""


def _run_lengths(
    flat: NDArray[np.int32], kinds: NDArray[np.int32], starts: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Of each number in the programs: how many neighbours of its kind follow it, it included."""
    if not len(flat):
        return flat
    kind = kinds[flat]
    goes_on = np.zeros(len(flat), dtype=bool)
    goes_on[:-1] = (np.diff(flat) == 1) & (kind[1:] == kind[:-1]) & np.isin(kind[:-1], _RUNS)
    ends = starts[1:-1]
    goes_on[ends[(ends > 0) & (ends <= len(flat))] - 1] = False
    last = np.flatnonzero(~goes_on)
    places = np.arange(len(flat))
    return (last[np.searchsorted(last, places)] - places + 1).astype(np.int32)


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


@dataclass(frozen=True, slots=True)
class Call:
    """A call-out to a Python component, or to ``forward`` or ``backward`` of a turned channel.

    Or what passes the texts of an FMU, and returns the status, or records those of a group.
    """

    component: str
    method: str
    is_channel: bool = False
    passes: Callable[[], int] | None = None
    records: Callable[[int], None] | None = None


class Program:
    """The kernel's structures; owns all memory that they point to."""

    def __init__(
        self,
        parts: Mapping[str, Part],
        wiring: Wiring,
        layout: Layout,
        clock: Clock,
        *,
        kernel: KernelStruct | None = None,
        knobs: Mapping[Name, Knob] | None = None,
    ) -> None:
        self.parts = parts
        self.wiring = wiring
        self.layout = layout
        self.clock = clock
        self.cells: NDArray[np.int64] = np.zeros(max(layout.count, 1), dtype=np.int64)
        self.packets = Packets(wiring.bundles, layout, self.cells)
        self.texts = CarriedTexts(parts, wiring.bundles, layout, self.cells)
        self.texts.packets = self.packets
        self.turning = Turning(knobs or {}, layout, self.cells)
        dials = dials_of([name for name in self.turning.knobs if name[0] not in parts], layout)
        self.channels = TurnedChannels(
            self.packets, clock.base_rate, self.cells.view(np.float64), dials
        )
        self.kernel = KernelStruct() if kernel is None else kernel
        self.actions: list[Action] = []
        """The action behind each operation."""
        self.calls: dict[int, Call] = {}
        """The call-out behind an operation."""
        self._operations: list[OperationStruct] = []
        self._accessors: list[tuple[int, str, VariableType, bool]] = []
        """The number of each operation that sets or gets, and whose accessor it calls."""
        self._operation_array: Any = None
        self._events: dict[str, EventStructures] = {}
        self._steps: dict[str, int] = {}
        """The number of an operation that steps each FMU."""
        self._is_initial = False
        """Whether what is written is the program of initialisation mode."""
        self._keep: list[Any] = []
        self._places = {name: place for place, name in enumerate(sorted(parts))}
        self._natives: Mapping[str, Native] = {}
        self.numbers: dict[str, int] = {}
        """The number of each FMU among ``instances``."""
        self._wires: dict[tuple[str, str], list[Wire]] = {}
        for wire in wiring.wires:
            key = (wire.target.component, wire.target.variable)
            self._wires.setdefault(key, []).append(wire)

    def view(self, component: str, variable: str) -> Cells:
        """The cells of a variable, with its shape; ``(1,)`` for a scalar."""
        described = self.parts[component].interface.variables[variable]
        first = self.layout.cells[component, variable]
        cells = self.cells[first : first + size_of(described)].reshape(described.shape or (1,))
        return cells.view(np.float64) if described.type.is_float else cells

    def compile(
        self,
        plan: Plan,
        natives: Mapping[str, Native],
        columns: Sequence[Sequence[int]],
        texts: Sequence[Sequence[int]] = (),
    ) -> None:
        """Fill the structures. ``columns`` holds the recorded cells of each group.

        ``texts`` are those of its texts.
        """
        self._texts = texts
        self._natives = natives
        self.numbers = {name: number for number, name in enumerate(sorted(natives))}
        self._columns = columns
        self.instances: Any = (InstanceStruct * max(len(natives), 1))()
        for name, number in self.numbers.items():
            native, period = natives[name], self.parts[name].period
            self.instances[number] = InstanceStruct(
                native.instance,
                native.do_step,
                native.version,
                period,
                native.substeps,
                self.clock.step(period, native.substeps),
                not native.is_trusted,
                0,
                native.substeps == 1 and name not in self.layout.events,
                None,
            )
        self.kernel.has_foreign = any(not native.is_trusted for native in natives.values())
        self.kernel.careful = _CAREFUL_TICKS if self.kernel.has_foreign else 0
        self.records: Any = (RecordStruct * max(len(columns), 1))()
        self._write_programs(plan)

    def rewind(self, wiring: Wiring) -> None:
        """Be before tick 0 again; ``wiring`` may have other fates in its bundles, nothing else."""
        self.wiring = wiring
        self.cells[:] = 0
        if not self.packets.rewind(wiring.bundles, self.layout):
            self.packets = Packets(wiring.bundles, self.layout, self.cells)
        self.channels.packets = self.texts.packets = self.packets
        kernel = self.kernel
        kernel.bundles = ctypes.addressof(self.packets.structs)
        kernel.tick = kernel.phase = kernel.position = kernel.status = kernel.event_call = 0
        kernel.running = -1

    def refresh(self) -> None:
        """Take note of FMUs that were made anew, and forget their warnings."""
        for name, number in self.numbers.items():
            self.instances[number].instance = self._natives[name].instance
            self.instances[number].do_step = self._natives[name].do_step
            self.instances[number].warnings = 0
        for name, events in self._events.items():
            events.bind(self._natives[name].events)
        for number, unit, kind, is_set in self._accessors:
            function = self._natives[unit].accessor(kind, is_set=is_set)
            self._operation_array[number].function = function

    def stopped_at(self) -> Action:
        """The action at which the kernel came back."""
        return self.actions[int(self.kernel.operation)]

    def warnings(self) -> dict[str, int]:
        """The warnings that FMUs have returned, by component."""
        counts = {name: self.instances[number].warnings for name, number in self.numbers.items()}
        return {name: count for name, count in counts.items() if count}

    def warn(self, component: str) -> None:
        """An FMU has returned a warning when its texts were passed."""
        self.instances[self.numbers[component]].warnings += 1

    def set_warnings(self, counts: Mapping[str, int]) -> None:
        """Count on from the warnings of an earlier part of the run, by component."""
        for name, number in self.numbers.items():
            self.instances[number].warnings = int(counts.get(name, 0))

    def _write_programs(self, plan: Plan) -> None:
        periods = [action.period for action in plan.every] or [1]
        hyperperiod = self.clock.hyperperiod(periods)
        due_sets, pattern = due_together(periods, hyperperiod)
        every = [(action.period, self._operation_numbers(action)) for action in plan.every]
        self._is_initial = True
        programs = [[n for action in plan.initial for n in self._operation_numbers(action)]]
        self._is_initial = False
        programs.append([n for action in plan.first for n in self._operation_numbers(action)])
        programs += [
            [number for period, numbers in every if period in due for number in numbers]
            for due in due_sets
        ]
        starts = np.cumsum([0, *map(len, programs)]).astype(np.int64)
        flat = np.array([number for program in programs for number in program], dtype=np.int32)
        shifted = (pattern + _EVERY).astype(np.int32)
        self._write_events(plan)
        operations = (OperationStruct * max(len(self._operations), 1))(*self._operations)
        self._operation_array = operations
        kinds = np.array([operation.kind for operation in self._operations], dtype=np.int32)
        lengths = _run_lengths(flat, kinds, starts)
        self._keep += [starts, flat, shifted, operations, lengths]

        tick = self.clock.tick
        kernel = self.kernel
        kernel.cells = self.cells.ctypes.data
        kernel.operations = ctypes.addressof(operations)
        kernel.program = flat.ctypes.data
        kernel.run_length = lengths.ctypes.data
        kernel.program_start = starts.ctypes.data
        kernel.pattern = shifted.ctypes.data
        kernel.hyperperiod = hyperperiod
        kernel.first_program = _FIRST
        kernel.instances = ctypes.addressof(self.instances)
        kernel.bundles = ctypes.addressof(self.packets.structs)
        kernel.records = ctypes.addressof(self.records)
        kernel.tick_numerator = tick.numerator
        kernel.tick_denominator = tick.denominator
        kernel.start_tick = self.clock.start_tick
        kernel.running = -1

    def _operation_numbers(self, action: Action) -> list[int]:
        first = len(self._operations)
        for operation in self._operations_of(action):
            self._operations.append(operation)
            self.actions.append(action)
        return list(range(first, len(self._operations)))

    def _operations_of(self, action: Action) -> Iterable[OperationStruct]:
        unit = action.unit
        if isinstance(unit, int):
            yield from self._bundle_operations(action, unit)
        elif action.act is Act.SET:
            set_always = [
                name
                for name in action.names
                if (unit, name) not in self.turning.knobs and not self._waits(unit, str(name))
            ]
            if unit not in self._natives or not set_always:
                yield from self._copies(unit, action.names)
            else:
                yield from self._copies_and_sets(unit, action.names, set_always)
                yield from self._text_calls(unit, set_always, is_set=True)
            if unit in self.parts:
                yield from self._tunes(unit, action.names)
        elif action.act is Act.TUNE:
            yield from self._tunes(unit, action.names)
        elif unit in self._natives:
            if action.act is Act.GET:
                latched = self.layout.latched
                read = [name for name in action.names if (unit, name) not in latched]
                yield from self._latches(unit, set(map(str, action.names)) - set(map(str, read)))
                yield from self._accesses(unit, read, is_set=False)
                yield from self._text_calls(unit, read, is_set=False)
            else:
                self._steps[unit] = len(self._operations)
                yield OperationStruct(kind=OperationKind.STEP, owner=self.numbers[unit])
        elif action.act is Act.GET and self.parts[unit].played is not None:
            yield from self._plays(unit, action.names)
        elif self.parts[unit].overrides(_CALLS[action.act]):
            self.calls[len(self._operations)] = Call(unit, _CALLS[action.act])
            yield OperationStruct(kind=OperationKind.CALL, owner=self._places[unit])

    def _plays(self, unit: str, names: Iterable[str | int]) -> Iterable[OperationStruct]:
        """One operation for each run of neighbouring cells."""
        part = self.parts[unit]
        assert part.played is not None
        outputs = [n for n, v in part.interface.variables.items() if v.causality == "output"]
        cells = sorted((self.layout.cells[unit, str(name)], str(name)) for name in names)
        for _, run in groupby(enumerate(cells), lambda item: item[1][0] - item[0]):
            members = [cell for _, cell in run]
            columns = [outputs.index(name) for _, name in members]
            rows = rows_to_play(part.played, columns, self.clock, part.period)
            self._keep.append(rows)
            yield OperationStruct(
                kind=OperationKind.PLAY,
                owner=self._places[unit],
                cells=self.cells.ctypes.data + 8 * members[0][0],
                table=ctypes.addressof(rows.struct),
            )

    def begin_events(self, component: str, phase: int) -> int:
        """The kernel's outcome of an FMU's events before tick 0, where its event mode is used.

        Phase 0 belongs to initialisation mode, phase 1 to the event mode that follows.
        """
        if component not in self._events:
            return KernelOutcome.DONE
        self.kernel.operation = self._steps[component]
        number = self.numbers[component]
        return library().kernel_begin_events(ctypes.addressof(self.kernel), number, phase)

    def fill_latched(self) -> None:
        """What is only read when clocks tick has its start value until then."""
        for (component, name), first in self.layout.latched.items():
            values = self.view(component, name).view(np.int64).reshape(-1)
            self.cells[first : first + values.size] = values

    def _waits(self, unit: str, name: str) -> bool:
        """Whether an input is not set where inputs are, but when an event takes place."""
        facts = self.parts[unit].interface.events if unit in self.parts else None
        if facts is None:
            return False
        if name in facts.clock_names():
            return True
        variable = self.parts[unit].interface.variables[name]
        return not self._is_initial and facts.is_event_input(variable)

    def _latches(self, unit: str, names: Iterable[str]) -> Iterable[OperationStruct]:
        """What was read at events becomes what the FMU puts out."""
        pairs = [
            (self.layout.latched[unit, name] + i, self.layout.cells[unit, name] + i)
            for name in sorted(names)
            for i in range(size_of(self.parts[unit].interface.variables[name]))
        ]
        if pairs:
            table = np.array(pairs, dtype=np.int32)
            yield self._with_table(OperationKind.COPY, table, len(pairs))

    def _write_events(self, plan: Plan) -> None:
        """Operations that belong to no program, but to the events of an FMU."""
        for unit in self.layout.events:
            native, part = self._natives[unit], self.parts[unit]
            step = part.period * self.clock.tick / native.substeps
            references = {name: native.reference(name) for name in self._clock_names(unit)}
            base = self.cells.ctypes.data
            events = EventStructures(part.interface, self.layout, base, references, step)
            driven = {
                str(name)
                for action in plan.every
                if action.act is Act.SET and action.unit == unit
                for name in action.names
                if (unit, name) not in self.turning.knobs
            }
            step_of = Action(Act.STEP, unit, part.period)
            numbers: list[dict[str, int]] = []
            for names, is_set in ((events.sets(driven), True), (events.gets(), False)):
                numbers.append({})
                for name in names:
                    for operation in self._accesses(unit, [name], is_set=is_set):
                        if not is_set:
                            operation.cells = events.place_of(name)
                        numbers[-1][name] = len(self._operations)
                        self._operations.append(operation)
                        self.actions.append(step_of)
            number = self.numbers[unit]
            self.instances[number].events = events.begin(*numbers)
            events.bind(native.events)
            self._events[unit] = events

    def _clock_names(self, unit: str) -> list[str]:
        facts = self.parts[unit].interface.events
        return [clock.name for clock in facts.clocks] if facts is not None else []

    def _bundle_operations(self, action: Action, number: int) -> Iterable[OperationStruct]:
        if action.act is Act.DELIVER:
            yield OperationStruct(kind=OperationKind.DELIVER, owner=number)
        elif action.act is Act.SEND:
            yield OperationStruct(kind=OperationKind.SEND, owner=number)
        elif action.act is Act.RECORD:
            columns = np.array(self._columns[number], dtype=np.int32)
            yield self._with_table(OperationKind.RECORD, columns, len(columns), owner=number)
            if number < len(self._texts) and self._texts[number]:
                records = self.texts.recorder(number, self._texts[number])
                self.calls[len(self._operations)] = Call("record", "texts", records=records)
                yield OperationStruct(kind=OperationKind.CALL)
        else:
            entries = self.wiring.bundles[number].entries
            indices = [int(name) for name in action.names]
            pairs = [
                (self.layout.of(entries[index].source), self.layout.held[number] + index)
                for index in indices
            ]
            kind = OperationKind.COPY if action.act is Act.HOLD else OperationKind.SAMPLE
            table = np.array(pairs, dtype=np.int32)
            yield self._with_table(kind, table, len(pairs), owner=number)

    def _copies(self, unit: str, names: Iterable[str | int]) -> Iterable[OperationStruct]:
        wires = [wire for name in names for wire in self._wires.get((unit, str(name)), [])]
        pairs = [
            (self.layout.of(wire.source), self.layout.into(wire.target))
            for wire in wires
            if wire.is_plain
        ]
        if pairs:
            yield self._with_table(
                OperationKind.COPY, np.array(sorted(pairs), dtype=np.int32), len(pairs)
            )
        converted = [wire for wire in wires if not wire.is_plain]
        if converted:
            table = (ConversionStruct * len(converted))(
                *(
                    ConversionStruct(
                        self.layout.of(wire.source),
                        self.layout.into(wire.target),
                        wire.from_integer,
                        wire.gain,
                        wire.offset,
                    )
                    for wire in converted
                )
            )
            self._keep.append(table)
            yield OperationStruct(
                kind=OperationKind.CONVERT, cell_count=len(converted), table=ctypes.addressof(table)
            )

    def _copies_and_sets(
        self, unit: str, names: Iterable[str | int], set_always: list[str | int]
    ) -> Iterable[OperationStruct]:
        """Plain copies alone, before reals are set, are made by the operation that sets them."""
        copies = list(self._copies(unit, names))
        first = min((str(name) for name in set_always), key=lambda n: self.layout.cells[unit, n])
        is_real = self.parts[unit].interface.variables[first].type is VariableType.FLOAT64
        if not is_real or [each.kind for each in copies] != [OperationKind.COPY]:
            yield from copies
            copies = []
        for operation in self._accesses(unit, set_always, is_set=True):
            for copy in copies:
                operation.table, operation.copy_count = copy.table, copy.cell_count
            copies = []
            yield operation

    def _accesses(
        self, unit: str, names: Iterable[str | int], *, is_set: bool
    ) -> Iterable[OperationStruct]:
        """One operation for each run of neighbouring cells of one type."""
        variables = self.parts[unit].interface.variables
        native = self._natives[unit]
        ordered = sorted(
            (self.layout.cells[unit, str(name)], str(name))
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
        for _, run in groupby(ordered, lambda item: bisect_right(begins, item[0])):
            members = list(run)
            kind = variables[members[0][1]].type
            count = sum(size_of(variables[name]) for _, name in members)
            references = np.array([native.reference(name) for _, name in members], np.uint32)
            codes = FMI2_TYPE_CODES if native.version == 2 else TYPE_CODES
            scratch = np.zeros(count, dtype=np.int64)
            self._keep += [references, scratch]
            direct = kind is VariableType.FLOAT64
            self._accessors.append((len(self._operations), unit, kind, is_set))
            yield OperationStruct(
                kind=(
                    (OperationKind.SET_FLOAT64 if direct else OperationKind.SET)
                    if is_set
                    else (OperationKind.GET_FLOAT64 if direct else OperationKind.GET)
                ),
                owner=self.numbers[unit],
                type=codes[kind],
                version=native.version,
                function=native.accessor(kind, is_set=is_set),
                references=references.ctypes.data,
                reference_count=len(references),
                cells=self.cells.ctypes.data + 8 * members[0][0],
                cell_count=count,
                scratch=scratch.ctypes.data,
                table=self._ranges([variables[name] for _, name in members]) if is_set else 0,
            )

    def _text_calls(
        self, unit: str, names: Iterable[str | int], *, is_set: bool
    ) -> Iterable[OperationStruct]:
        """A call-out for each type of text among the variables."""
        fmu = self._natives[unit]
        for passing in self.texts.passings(unit, [str(name) for name in names]):
            make = self.texts.setter if is_set else self.texts.getter
            call = Call(unit, f"{'set' if is_set else 'get'}_texts", passes=make(passing, fmu))
            self.calls[len(self._operations)] = call
            yield OperationStruct(kind=OperationKind.CALL, owner=self._places[unit])

    def _ranges(self, variables: Sequence[Variable]) -> int:
        """The least and the most of each element of enumerations; 0 where there are none."""
        if not all(variable.items for variable in variables):
            return 0
        limits = [
            (min(items.values()), max(items.values()))
            for variable in variables
            if (items := variable.items)
            for _ in range(size_of(variable))
        ]
        table = np.array(limits, dtype=np.int64)
        self._keep.append(table)
        return table.ctypes.data

    def _tunes(self, unit: str, names: Iterable[str | int]) -> Iterable[OperationStruct]:
        """One operation for each of the variables that may be turned."""
        for name in map(str, names):
            if (unit, name) not in self.turning.knobs:
                continue
            is_channel = unit not in self.parts
            if is_channel:
                way = name.partition(".")[0]
                self.calls[len(self._operations)] = Call(unit, way, is_channel=True)
            native, owner = self._natives.get(unit), self.numbers.get(unit, 0)
            if native is not None:
                kind = self.turning.knobs[unit, name].variable.type
                self._accessors.append((len(self._operations), unit, kind, True))
            yield self.turning.operation((unit, name), native, owner, by_call=is_channel)

    def _with_table(
        self, kind: OperationKind, table: NDArray[np.int32], count: int, *, owner: int = 0
    ) -> OperationStruct:
        self._keep.append(table)
        return OperationStruct(kind=kind, owner=owner, cell_count=count, table=table.ctypes.data)
