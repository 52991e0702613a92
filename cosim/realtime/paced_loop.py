"""The loop in real time: one tick a call of the kernel, with as little Python as that takes.

The same plan as a simulation's loop, and the same numbers. What can be looked up is looked up
before the first tick: at 1024 Hz caches are cold when a tick begins, and every name costs.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cosim.base.component import Component
from cosim.base.errors import CohapticError, RunError
from cosim.base.recording import RecordGroup, Rows, Sink
from cosim.master.channels.packets import BLOCK
from cosim.master.components.blame import told
from cosim.master.kernel.codes import KernelOutcome
from cosim.master.kernel.native import library
from cosim.master.kernel.program import Program
from cosim.master.run.diagnosis import moment
from cosim.master.run.execution.loop import Drive
from cosim.master.run.guard import StatusReturnedError, guarded
from cosim.master.run.interrupt import Wish
from cosim.realtime.pacing import Pacer, Work

MODELS, RECORD = "models", "record"
"""The parts of a tick that are no component's: the kernel's, and handing rows over."""


def paced(pacer: Pacer) -> Drive:
    """What runs a simulation at a pace: ``simulation.run(drive=paced(pacer))``."""

    def drive(
        program: Program,
        components: Mapping[str, Component],
        groups: Sequence[RecordGroup],
        sink: Sink | None,
        *,
        end: int,
        wish: Wish,
    ) -> KernelOutcome:
        return PacedLoop(program, components, groups, sink).run(end, pacer, wish)

    return drive


class PacedLoop:
    """Runs a compiled program tick by tick; ``sink`` takes one row at a time."""

    def __init__(
        self,
        program: Program,
        components: Mapping[str, Component],
        groups: Sequence[RecordGroup],
        sink: Sink | None,
    ) -> None:
        self._program = program
        self._sink = sink
        self._groups = [(number, group.period) for number, group in enumerate(groups)]
        self._records: list[Any] = [program.records[number] for number, _ in self._groups]
        self._rows: list[Rows | None] = [None] * len(groups)
        self._names = [MODELS, RECORD]
        self._handlers: dict[int, tuple[Callable[[int], None], int]] = {}
        for operation, call in program.calls.items():
            name = f"{call.component}.{call.method}"
            if name not in self._names:
                self._names.append(name)
            handler = guarded(program, components, call)
            self._handlers[operation] = (handler, self._names.index(name))

    def run(self, end: int, pacer: Pacer, wish: Wish) -> KernelOutcome:
        """Run until tick ``end``, a wish, or what the kernel comes back for otherwise.

        Raises:
            RunError: a component failed.
        """
        program, kernel = self._program, self._program.kernel
        work = pacer.work or Work()
        work.begin(self._names)
        advance, address = library().kernel_run, ctypes.addressof(kernel)
        clock, handlers, call = time.monotonic_ns, self._handlers, int(KernelOutcome.CALL)
        asked = program.turning.asked
        first = tick = int(kernel.tick)
        pacer.start(tick)
        while tick < end and not wish.is_made:
            pacer.wait(tick)
            # One packet a tick at most: fates for half a block last half a block of ticks.
            if tick == first or tick % (BLOCK // 2) == 0:
                program.packets.draw()
            if asked:
                program.turning.turn_as_asked(tick)
            self._open(tick)
            models, since = 0, clock()
            try:
                while (outcome := advance(address, tick + 1)) == call:
                    called = clock()
                    handler, part = handlers[kernel.operation]
                    handler(tick)
                    now = clock()
                    work.add(part, now - called)
                    models, since = models + called - since, now
            except StatusReturnedError:
                outcome = int(KernelOutcome.STATUS)
            except CohapticError:
                raise
            except Exception as error:
                failed = program.calls[int(kernel.operation)]
                raise RunError(
                    f"{failed.component} failed in {failed.method} at {moment(program)}: "
                    f"{told(error)}"
                ) from error
            finally:
                stepped = clock()
                self._commit(tick)
            work.add(0, models + stepped - since)
            work.add(1, clock() - stepped)
            if outcome:
                return KernelOutcome(outcome)
            tick += 1
        return KernelOutcome.DONE

    def _open(self, tick: int) -> None:
        sink = self._sink
        if sink is None:
            return
        for number, period in self._groups:
            if tick % period == 0:
                rows = sink.buffer(number, 1)
                record = self._records[number]
                if rows is not self._rows[number]:
                    record.rows = rows.ctypes.data
                    self._rows[number] = rows
                record.row, record.row_count = 0, 1

    def _commit(self, tick: int) -> None:
        sink = self._sink
        if sink is None:
            return
        for number, period in self._groups:
            if tick % period == 0:
                sink.commit(number, tick, self._records[number].row)
