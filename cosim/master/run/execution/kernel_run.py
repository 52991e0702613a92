"""A program run by the kernel: call-outs served, rows handed over, a stop turned into its error."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence

from cosim.base.component import Component
from cosim.base.errors import EndAsked
from cosim.base.recording import RecordGroup, Rows, Sink
from cosim.master.assembly.assemble import Assembly
from cosim.master.components.python_component import sentences
from cosim.master.fmu.refusal import placed_refusal
from cosim.master.kernel.codes import KernelOutcome as Stop
from cosim.master.kernel.due_programs import INITIAL
from cosim.master.kernel.native import library
from cosim.master.kernel.program import Program
from cosim.master.run.diagnosis import explain, moment
from cosim.master.run.execution.fmus import RunningFmus
from cosim.master.run.guard import StatusReturnedError, guarded

LONGEST_CHUNK = 1024
"""Ticks that the kernel runs in one go at most."""


class KernelRun:
    """One run of an assembly in the kernel."""

    def __init__(
        self,
        assembly: Assembly,
        program: Program,
        fmus: RunningFmus,
        components: Mapping[str, Component],
    ) -> None:
        self.assembly = assembly
        self.program = program
        self.fmus = fmus
        self.components = components
        self._handlers: dict[int, Callable[[int], None]] = {}
        self._rows: dict[int, Rows] = {}

    @property
    def groups(self) -> Sequence[RecordGroup]:
        """What is recorded."""
        return self.assembly.groups

    def initialise(self) -> None:
        """Pass the first values along, in initialisation mode.

        Raises:
            InputError: an FMU refuses what it was given.
            RunError: a component failed.
        """
        while (stop := self._evaluate()) is Stop.CALL:
            self._serve()
        self.raise_unless_done(stop)

    def begin_events(self, name: str, phase: int) -> None:
        """What an FMU in event mode does before tick 0; see ``Program.begin_events``."""
        self.raise_unless_done(Stop(self.program.begin_events(name, phase)))

    def run_chunk(self, first: int, stop: int, sink: Sink | None) -> None:
        """Run the ticks from ``first`` up to ``stop``; their rows go to ``sink``, also of a part.

        Raises:
            EndAsked: a model has come to its end, which is a good one.
            RunError: an FMU returned an error status, put out NaN, or a component failed.
        """
        self.program.packets.draw()
        self.program.turning.turn_as_asked(first)
        if sink is not None:
            self._open_rows(first, stop, sink)
        try:
            while (outcome := self._advance(stop)) is Stop.CALL:
                self._serve()
            self.raise_unless_done(outcome)
        finally:
            if sink is not None:
                self._commit_rows(first, sink)

    def run_to(self, tick: int, sink: Sink | None) -> None:
        """Run up to a tick, as ``run_chunk`` does."""
        self.fmus.refuse_lost()
        kernel = self.program.kernel
        with self.fmus.guarded:
            while kernel.tick < tick:
                self.run_chunk(kernel.tick, min(tick, kernel.tick + LONGEST_CHUNK), sink)

    def raise_unless_done(self, stop: Stop) -> None:
        """Raise the error that the kernel's coming back stands for, if it does."""
        if stop is not Stop.DONE:
            component, fmus = str(self.program.stopped_at().unit), self.fmus.all
            if stop is Stop.STATUS and component in fmus:
                fmus[component].judge(int(self.program.kernel.status))
            error = explain(stop, self.program, fmus)
            if not isinstance(error, EndAsked):
                self.fmus.fail(component)
            with placed_refusal(self.assembly.scenario, component):
                raise error

    def _advance(self, stop: int) -> Stop:
        return Stop(library().kernel_run(ctypes.addressof(self.program.kernel), stop))

    def _evaluate(self) -> Stop:
        return Stop(library().kernel_evaluate(ctypes.addressof(self.program.kernel), INITIAL))

    def _serve(self) -> None:
        operation = int(self.program.kernel.operation)
        call = self.program.calls[operation]
        if operation not in self._handlers:
            self._handlers[operation] = guarded(self.program, self.components, call)
        try:
            with sentences(call.component, f"in {call.method} at {moment(self.program)}"):
                self._handlers[operation](int(self.program.kernel.tick))
        except StatusReturnedError:
            self.raise_unless_done(Stop.STATUS)

    def _open_rows(self, first: int, stop: int, sink: Sink) -> None:
        for number, group in enumerate(self.groups):
            rows = -(-stop // group.period) - -(-first // group.period)
            record = self.program.records[number]
            record.row, record.row_count = 0, rows
            if rows:
                self._rows[number] = sink.buffer(number, rows)
                record.rows = self._rows[number].ctypes.data

    def _commit_rows(self, first: int, sink: Sink) -> None:
        for number, group in enumerate(self.groups):
            record = self.program.records[number]
            if record.row_count:
                sink.commit(number, -(-first // group.period) * group.period, record.row)
