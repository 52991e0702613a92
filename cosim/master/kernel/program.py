"""What the kernel runs: its structure, its cells, and all memory that these point to."""

from __future__ import annotations

import ctypes
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Cells
from cosim.master.assembly.clock import Clock
from cosim.master.assembly.knobs import Knob, Name
from cosim.master.assembly.layout import Layout
from cosim.master.assembly.plan import Act, Action, Part, Plan
from cosim.master.assembly.wiring import Wiring
from cosim.master.channels.packets import Packets
from cosim.master.channels.texts import CarriedTexts
from cosim.master.channels.turning import TurnedChannels, dials_of
from cosim.master.components.interface import size_of
from cosim.master.kernel.accesses import Native
from cosim.master.kernel.codes import KernelOutcome
from cosim.master.kernel.due_programs import DuePrograms
from cosim.master.kernel.event_operations import write_events
from cosim.master.kernel.events import EventStructures
from cosim.master.kernel.native import library
from cosim.master.kernel.operations import Operations
from cosim.master.kernel.structures import (
    InstanceStruct,
    KernelStruct,
    OperationStruct,
    RecordStruct,
)
from cosim.master.kernel.turning import Turning
from cosim.master.kernel.written import Call

_CAREFUL_TICKS = 64
"""For which every call of a foreign FMU is looked after; see ``sources/kernel.c``."""


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
        self.numbers: Mapping[str, int] = {}
        """The number of each FMU among ``instances``; none before ``compile``."""
        self.operations: Operations
        """Written by ``compile``, as what follows is."""
        self.instances: Any
        self._warnings: NDArray[np.int64]
        """How many each FMU has returned, among ``instances``."""
        self.records: Any
        self._operation_array: Any
        self._programs: DuePrograms
        self._events: dict[str, EventStructures] = {}
        self._natives: Mapping[str, Native] = {}

    @property
    def early(self) -> Collection[int]:
        """The operations of initialisation mode and of tick 0; the others belong to every tick."""
        return self._programs.early

    @property
    def calls(self) -> Mapping[int, Call]:
        """The call-out behind an operation."""
        return self.operations.calls

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
        self._natives = natives
        self.operations = Operations(
            self.parts,
            self.wiring,
            self.layout,
            self.clock,
            self.cells,
            turning=self.turning,
            texts=self.texts,
            natives=natives,
            recorded=(columns, texts),
        )
        self.numbers = self.operations.instances
        self.instances = (InstanceStruct * max(len(natives), 1))()
        rows: NDArray[Any] = np.frombuffer(self.instances, np.dtype(InstanceStruct))
        self._warnings = rows["warnings"]
        for name, number in self.numbers.items():
            self.instances[number] = self._instance(name, natives[name])
        self.records = (RecordStruct * max(len(columns), 1))()
        self._programs = DuePrograms(plan, self.clock, self.operations)
        for name in self.layout.events:
            self._write_events(name, plan)
        self.operations.point_to(ctypes.addressof(self.instances))
        written = self.operations.all
        self._operation_array = (OperationStruct * max(len(written), 1))(*written)
        self._bind_kernel()

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
        for number, (component, kind, is_set) in self.operations.accessors:
            function = self._natives[component].accessor(kind, is_set=is_set)
            self._operation_array[number].function = function

    def stopped_at(self) -> Action:
        """The action at which the kernel came back."""
        return self.operations.actions[int(self.kernel.operation)]

    def warnings(self) -> dict[str, int]:
        """The warnings that FMUs have returned, by component."""
        counts: list[int] = self._warnings.tolist() if self.numbers else []
        return {name: counts[number] for name, number in self.numbers.items() if counts[number]}

    def warn(self, component: str) -> None:
        """An FMU has returned a warning when its texts were passed."""
        self.instances[self.numbers[component]].warnings += 1

    def set_warnings(self, counts: Mapping[str, int]) -> None:
        """Count on from the warnings of an earlier part of the run, by component."""
        if not self.numbers:
            return
        self._warnings[:] = 0
        for name, number in self.numbers.items() if counts else ():
            self._warnings[number] = int(counts.get(name, 0))

    def begin_events(self, component: str, phase: int) -> int:
        """The kernel's outcome of an FMU's events before tick 0, where its event mode is used.

        Phase 0 belongs to initialisation mode, phase 1 to the event mode that follows.
        """
        if component not in self._events:
            return KernelOutcome.DONE
        self.kernel.operation = self.operations.steps[component]
        number = self.numbers[component]
        return library().kernel_begin_events(ctypes.addressof(self.kernel), number, phase)

    def fill_latched(self) -> None:
        """What is only read when clocks tick has its start value until then."""
        for (component, name), first in self.layout.latched.items():
            values = self.view(component, name).view(np.int64).reshape(-1)
            self.cells[first : first + values.size] = values

    def _instance(self, name: str, native: Native) -> InstanceStruct:
        period = self.parts[name].period
        return InstanceStruct(
            native.instance,
            native.do_step,
            native.version,
            period,
            native.substeps,
            self.clock.step(period, native.substeps),
            not native.is_trusted,
            0,
            None,
        )

    def _write_events(self, name: str, plan: Plan) -> None:
        native, part = self._natives[name], self.parts[name]
        facts = part.interface.events
        assert facts is not None
        references = {clock.name: native.reference(clock.name) for clock in facts.clocks}
        length = part.period * self.clock.tick / native.substeps
        cells = self.cells.ctypes.data
        events = EventStructures(part.interface, self.layout, cells, references, length)
        step = Action(Act.STEP, name, part.period)
        address = write_events(events, step, plan, self.turning, self.operations)
        self.instances[self.numbers[name]].events = address
        events.bind(native.events)
        self._events[name] = events

    def _bind_kernel(self) -> None:
        kernel, tick = self.kernel, self.clock.tick
        kernel.has_foreign = any(not native.is_trusted for native in self._natives.values())
        kernel.careful = _CAREFUL_TICKS if kernel.has_foreign else 0
        kernel.cells = self.cells.ctypes.data
        kernel.operations = ctypes.addressof(self._operation_array)
        self._programs.bind(kernel)
        kernel.instances = ctypes.addressof(self.instances)
        kernel.bundles = ctypes.addressof(self.packets.structs)
        kernel.records = ctypes.addressof(self.records)
        kernel.tick_numerator = tick.numerator
        kernel.tick_denominator = tick.denominator
        kernel.start_tick = self.clock.start_tick
        kernel.running = -1
