"""Worker processes on this machine, one pipe each: what kills a worker costs the one run it was at.

A worker that dies (a crash in native code, a signal, a lack of memory) is replaced, the run that it
was at is tried once more by itself, and what else it was given goes to others.
"""

from __future__ import annotations

import os
import pickle
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from selectors import EVENT_READ, DefaultSelector
from types import TracebackType
from typing import IO

from cosim.base.errors import RunError
from cosim.sweep.job import Job, RunResult, Task
from cosim.sweep.work.message_socket import MessageSocket
from cosim.sweep.work.messages import READY, ResultReader, task_bytes
from cosim.sweep.work.traces import last_words, traces_file
from cosim.sweep.work.variants import Variants

AHEAD = 2
"""Runs that a worker is given at a time: while it answers one it has the next."""
ATTEMPTS = 2
"""How often a run may kill its worker before it is left alone."""
_ENDED = 5.0
"""Time that a worker has to end when it is told to (s)."""
_NO_START = 3
"""Workers that may die one after another without having answered once."""


@dataclass(slots=True)
class _Worker:
    process: subprocess.Popen[bytes]
    pipe: MessageSocket
    traces: IO[bytes]
    """What its runs are doing."""
    given: deque[Task] = field(default_factory=deque[Task])
    reader: ResultReader = field(default_factory=ResultReader)
    began: float = 0.0
    answered: bool = False


class LocalPool:
    """``count`` workers; a context manager that ends them on every exit path."""

    def __init__(self, job: Job, count: int | None = None, *, timeout: float | None = None) -> None:
        """``timeout`` (s) is the longest that one run may take; then its worker is killed."""
        self._job = job
        self._count = max(1, processors() if count is None else count)
        self._timeout = timeout
        self._workers: list[_Worker] = []
        self._speaking = DefaultSelector()
        self._deaths: dict[int, int] = {}
        self._stillborn = 0

    def __enter__(self) -> LocalPool:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def start(self) -> None:
        """Start every worker and wait until each has read the scenario."""
        while len(self._workers) < self._count:
            self._workers.append(self._hire())
        for worker in self._workers:
            with suppress(EOFError, OSError):
                while READY not in worker.pipe.receive():
                    pass

    @property
    def processes(self) -> list[int]:
        """The workers' process ids."""
        return [worker.process.pid for worker in self._workers]

    def run(self, tasks: Iterable[Task]) -> Iterator[RunResult]:
        """The results in the order in which they come.

        Raises:
            RunError: no worker comes to life.
        """
        if not self._workers:
            self.start()
        waiting = iter(tasks)
        again: deque[Task] = deque()
        alone: deque[Task] = deque()
        while True:
            self._give(waiting, again, alone)
            busy = [worker for worker in self._workers if worker.given]
            if not busy:
                return
            for key, _ in self._speaking.select(self._patience(busy)):
                yield from self._hear(key.data, again, alone)
            self._end_those_that_hang()

    def close(self) -> None:
        """End every worker."""
        self._speaking.close()
        for worker in self._workers:
            worker.pipe.close()  # the worker ends when it finds nobody there
        for worker in self._workers:
            worker.traces.close()
            try:
                worker.process.wait(0.0 if worker.given else _ENDED)
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()
        self._workers.clear()

    def _give(self, waiting: Iterator[Task], again: deque[Task], alone: deque[Task]) -> None:
        """Give every worker something to do; what killed one is done by itself, last."""
        for worker in self._workers:
            while len(worker.given) < AHEAD:
                task = again.popleft() if again else next(waiting, None)
                if task is None:
                    break
                self._send(worker, task)
        idle = next((worker for worker in self._workers if not worker.given), None)
        if alone and idle is not None and not any(w.given for w in self._workers):
            self._send(idle, alone.popleft())

    def _send(self, worker: _Worker, task: Task) -> None:
        if not worker.given:
            worker.began = time.monotonic()
        worker.given.append(task)
        with suppress(OSError):  # a worker that is dead is found so when it is heard
            worker.pipe.send(task_bytes(task))

    def _hear(self, worker: _Worker, again: deque[Task], alone: deque[Task]) -> Iterator[RunResult]:
        try:
            messages = worker.pipe.receive()
        except (EOFError, OSError):
            yield from self._bury(worker, again, alone)
            return
        for said in messages:
            if said == READY:
                worker.began = time.monotonic()
                continue
            worker.answered, self._stillborn = True, 0
            worker.began = time.monotonic()
            yield worker.reader.read(said, worker.given.popleft())

    def _bury(self, worker: _Worker, again: deque[Task], alone: deque[Task]) -> Iterator[RunResult]:
        self._speaking.unregister(worker.pipe)
        worker.pipe.close()
        status = worker.process.wait()
        self._workers.remove(worker)
        why = self._last_words(worker, status)
        if not worker.answered:
            self._stillborn += 1
            if self._stillborn >= _NO_START * self._count:
                raise RunError(f"The workers of the sweep die at once: {why}.")
        if worker.given:  # else it was killed while it had nothing to do
            lost, *others = worker.given
            again.extend(others)
            self._deaths[lost.number] = self._deaths.get(lost.number, 0) + 1
            if self._deaths[lost.number] < ATTEMPTS:
                alone.append(lost)
            else:
                message = f"{why}; it was tried {ATTEMPTS} times."
                yield RunResult(lost.number, lost.key, lost.point, "crashed", message)
        self._workers.append(self._hire())

    def _last_words(self, worker: _Worker, status: int) -> str:
        with worker.traces:
            if not worker.given:
                return f"one ended with status {status} while it had nothing to do"
            scenario = Variants(self._job).scenario(worker.given[0].point)
            return last_words(worker.traces.fileno(), status, scenario)

    def _end_those_that_hang(self) -> None:
        if self._timeout is None:
            return
        since = time.monotonic() - self._timeout
        for worker in self._workers:
            if worker.given and worker.began < since:
                worker.process.kill()

    def _patience(self, busy: list[_Worker]) -> float | None:
        if self._timeout is None:
            return None
        first = min(worker.began for worker in busy)
        return max(0.05, first + self._timeout - time.monotonic())

    def _hire(self) -> _Worker:
        ours, theirs = socket.socketpair()
        traces = traces_file()  # closed when the worker is gone
        with theirs:
            passed = [theirs.fileno(), traces.fileno()]
            process = subprocess.Popen(
                [sys.executable, "-m", "cosim.sweep.work.worker", *map(str, passed)],
                pass_fds=passed,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for this process, which ends them
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        pipe = MessageSocket(ours)
        with suppress(OSError):
            pipe.send(pickle.dumps(self._job))
        worker = _Worker(process, pipe, traces)
        self._speaking.register(pipe, EVENT_READ, worker)
        return worker


def processors() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
