"""The loop by chunks: as many ticks in one go as leave Ctrl-C, pauses and progress in time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from cosim.base.component import Component
from cosim.base.recording import RecordGroup, Sink
from cosim.master.kernel.codes import KernelOutcome
from cosim.master.kernel.program import Program
from cosim.master.run.execution.kernel_run import LONGEST_CHUNK, KernelRun
from cosim.master.run.interrupt import Wish

FIRST_CHUNK = 1
CHUNK_SECONDS = (0.005, 0.05)
"""A chunk grows while it takes less than the first and shrinks where it takes more than the second,
so that Ctrl-C is heard soon."""


class Drive(Protocol):
    """Runs a program in place of the loop by chunks; the pace is its own, the numbers are not."""

    def __call__(
        self,
        program: Program,
        components: Mapping[str, Component],
        groups: Sequence[RecordGroup],
        sink: Sink | None,
        *,
        end: int,
        wish: Wish,
    ) -> KernelOutcome:
        """Run until tick ``end``, a wish, or what the kernel comes back for otherwise."""
        ...


Pause = Callable[[], None]
"""Called between two ticks."""

Progress = Callable[[int, float], None]
"""Told the ticks done and the loop's wall time (s), a few times a second."""


class ChunkedLoop:
    """Runs ticks; what it learned of the length of a chunk it keeps from run to run."""

    def __init__(self) -> None:
        self.wall_time = 0.0
        """Time spent in the loop last (s)."""
        self._chunk = FIRST_CHUNK

    def run(
        self,
        run: KernelRun,
        end: int,
        sink: Sink | None,
        wish: Wish,
        *,
        pauses: Mapping[int, Pause],
        progress: Progress | None,
    ) -> None:
        """Run to tick ``end`` or a wish, with a pause before each tick that has one.

        Raises:
            EndAsked, RunError: as ``KernelRun.run_chunk``.
        """
        kernel = run.program.kernel
        stops = sorted(tick for tick in pauses if kernel.tick <= tick <= end)
        told = began = time.perf_counter()
        try:
            while kernel.tick < end and not wish.is_made:
                if stops and kernel.tick == stops[0]:
                    pauses[stops.pop(0)]()
                first = kernel.tick
                stop = min(end, first + self._chunk, *stops[:1])
                before = time.perf_counter()
                with run.fmus.guarded:
                    run.run_chunk(first, stop, sink)
                now = time.perf_counter()
                self._learn(now - before)
                if progress is not None and (now - told > 0.1 or kernel.tick == end):
                    told = now
                    progress(kernel.tick, now - began)
            if stops and kernel.tick == stops[0]:
                pauses[stops.pop(0)]()
        finally:
            self.wall_time = time.perf_counter() - began

    def drive(self, drive: Drive, run: KernelRun, end: int, sink: Sink | None, wish: Wish) -> None:
        """Have ``drive`` run the ticks instead.

        Raises:
            EndAsked, RunError: as ``KernelRun.run_chunk``.
        """
        began = time.perf_counter()
        try:
            with run.fmus.guarded:
                stop = drive(run.program, run.components, run.groups, sink, end=end, wish=wish)
                run.raise_unless_done(stop)
        finally:
            self.wall_time = time.perf_counter() - began

    def _learn(self, seconds: float) -> None:
        """Choose the next chunk's length by the time that the last one took."""
        if seconds < CHUNK_SECONDS[0]:
            self._chunk = min(2 * self._chunk, LONGEST_CHUNK)
        elif seconds > CHUNK_SECONDS[1]:
            self._chunk = max(self._chunk // 2, 1)
