"""The kernel's structures for FMUs whose event mode is used: clocks, and what is done at events."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from cosim.base.component import Causality
from cosim.master.assembly.layout import Layout
from cosim.master.components.clocks import ClockFacts, EventFacts
from cosim.master.components.interface import Interface
from cosim.master.kernel.codes import CLOCK_CELLS, ClockKind
from cosim.master.kernel.event_structures import EventAccessStruct, EventClockStruct, EventsStruct

_FUNCTIONS = ("enter", "leave", "update", "set_clock", "get_clock", "get_interval", "get_shift")
_KINDS = {
    "constant": ClockKind.PERIODIC,
    "fixed": ClockKind.PERIODIC,
    "tunable": ClockKind.TUNABLE,
    "changing": ClockKind.CHANGING,
    "countdown": ClockKind.COUNTDOWN,
}


class EventStructures:
    """Those of one FMU; owns the memory that they point to."""

    def __init__(
        self,
        interface: Interface,
        layout: Layout,
        cells: int,
        references: Mapping[str, int],
        step: Fraction,
    ) -> None:
        assert interface.events is not None
        self.facts: EventFacts = interface.events
        self.interface = interface
        self._layout, self._cells, self._step = layout, cells, step
        self._first = layout.events[interface.component]
        self._bits = {clock.name: 1 << i for i, clock in enumerate(self.facts.clocks)}
        references_of = [references[clock.name] for clock in self.facts.clocks]
        self._references = np.array(references_of, dtype=np.uint32)
        self._clocks = (EventClockStruct * max(len(references_of), 1))(
            *(self._clock(number, clock) for number, clock in enumerate(self.facts.clocks))
        )
        self.struct = EventsStruct(
            clocks=ctypes.addressof(self._clocks),
            clock_count=len(references_of),
            next=self._address(self._first),
            may_return=self.facts.may_return,
        )
        self._accesses: list[Any] = []

    def sets(self, connected: Iterable[str]) -> list[str]:
        """Of the inputs that something drives, those that are set at events."""
        inputs = (self.interface.variables[name] for name in sorted(connected))
        clocks = self.facts.clock_names()
        return [
            variable.name
            for variable in inputs
            if variable.name not in clocks
            and variable.causality is Causality.INPUT
            and self.facts.is_event_input(variable)
        ]

    def gets(self) -> list[str]:
        """The variables that are read when their clocks tick."""
        variables = self.interface.variables
        return [
            name for name in self.facts.clocked if variables[name].causality is not Causality.INPUT
        ]

    def place_of(self, name: str) -> int:
        """Where the kernel puts what it reads of a variable at an event."""
        return self._address(self._layout.latched[self.interface.component, name])

    def begin(self, sets: Mapping[str, int], gets: Mapping[str, int]) -> int:
        """The address of the structure; ``sets`` and ``gets`` are numbers of operations."""
        for kind, numbers in (("set", sets), ("get", gets)):
            array = (EventAccessStruct * max(len(numbers), 1))(
                *(self._access(name, number) for name, number in numbers.items())
            )
            self._accesses.append(array)
            setattr(self.struct, f"{kind}s", ctypes.addressof(array))
            setattr(self.struct, f"{kind}_count", len(numbers))
        return ctypes.addressof(self.struct)

    def bind(self, functions: Iterable[int]) -> None:
        """Take note of where the FMU's functions are."""
        for name, address in zip(_FUNCTIONS, functions, strict=True):
            setattr(self.struct, name, address)

    def _access(self, name: str, operation: int) -> EventAccessStruct:
        before = self._layout.before.get((self.interface.component, name))
        return EventAccessStruct(
            operation=operation,
            clocks=self._bits_of(self.facts.clocked.get(name, ())),
            at_start=name in self.facts.at_start,
            before=None if before is None else self._address(before),
        )

    def _clock(self, number: int, clock: ClockFacts) -> EventClockStruct:
        is_input = clock.is_triggered_input
        told = ClockKind.TRIGGERED if is_input else ClockKind.TOLD
        kind = _KINDS.get(clock.variability, told)
        if kind is ClockKind.TUNABLE and clock.interval is not None:
            kind = ClockKind.PERIODIC  # the interval is ours to change, and we do not
        place = self._layout.cells[self.interface.component, clock.name]
        return EventClockStruct(
            kind=kind,
            reference=self._references.ctypes.data + 4 * number,
            interval=-1 if clock.interval is None else self._steps(clock.interval),
            shift=self._steps(clock.shift) if clock.interval is not None else -1,
            of=self._bits_of(clock.of),
            input=self._address(place) if is_input else None,
            cells=self._address(self._first + 1 + number * CLOCK_CELLS),
        )

    def _bits_of(self, clocks: Iterable[str]) -> int:
        return sum(self._bits[name] for name in set(clocks))

    def _steps(self, time: Fraction) -> int:
        return int(time / self._step)

    def _address(self, cell: int) -> int:
        return self._cells + 8 * cell
