"""Workers of a Dask cluster: chunks of runs, some under way, and a scheduler that may die.

A chunk whose worker died again and again is sent once more, to be run in a process beside a worker:
the run that kills is found, says what it was at, and kills no worker more. When the scheduler is
gone, what is known is kept and a sentence says how to go on.
"""

from __future__ import annotations

import hashlib
import importlib
import logging
import pickle
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any

from cosim.base.errors import InputError, RunError
from cosim.sweep.job import Job, RunResult, Task
from cosim.sweep.work.pool import LocalPool
from cosim.sweep.work.runner import PointRunner

CHUNK = 20
"""Runs that are sent together: a task costs some 2 ms."""
UNDER_WAY = 4
"""Chunks under way for each worker."""
_LOOK_SECONDS = 1.0
_LOST = (
    "The connection to Dask's scheduler is lost. What is known is kept: start the scheduler and "
    "its workers again, and this sweep with the same --out."
)
_CONNECT_SECONDS = 10

_lock = threading.Lock()
_runner: tuple[str, PointRunner] | None = None


@dataclass(frozen=True, slots=True)
class _Chunk:
    """Runs that are sent together."""

    tasks: list[Task]
    is_suspect: bool = False
    """Workers died of it."""


class DaskPool:
    """Runs tasks on a cluster's workers; a context manager that lets go of it."""

    def __init__(self, job: Job, scheduler: Any, *, chunk: int = CHUNK) -> None:
        """``scheduler`` is an address (``tcp://host:8786``) or a ``distributed.Client``.

        Raises:
            InputError: Dask is not installed, or nobody is at the address.
        """
        try:
            self._dask: Any = importlib.import_module("distributed")
        except ImportError:
            raise InputError("--scheduler needs Dask: pip install 'cohaptic[cluster]'.") from None
        _silence("distributed", "tornado", "asyncio")  # what they log is said in a sentence here
        self._job = job
        self._chunk = chunk
        self._over: SimpleQueue[Any] = SimpleQueue()
        self._is_own = isinstance(scheduler, str)
        try:
            self._client: Any = (
                self._dask.Client(scheduler, timeout=_CONNECT_SECONDS, set_as_default=False)
                if self._is_own
                else scheduler
            )
        except (OSError, ValueError) as error:
            raise InputError(f"there is no scheduler at {scheduler}: {error}") from None

    def __enter__(self) -> DaskPool:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._is_own:
            self._client.close(timeout=2)

    def run(self, tasks: Iterable[Task]) -> Iterator[RunResult]:
        """The results in the order in which they come.

        Raises:
            RunError: the scheduler is gone.
        """
        try:
            yield from self._run(iter(tasks))
        except OSError as error:  # a connection of the client's that broke off
            raise RunError(_LOST) from error

    def _run(self, waiting: Iterator[Task]) -> Iterator[RunResult]:
        again: deque[_Chunk] = deque()
        under_way: dict[Any, _Chunk] = {}
        # It travels with every chunk: what was scattered is lost with the last worker that has it,
        # and then nothing is run and nothing is said.
        job = pickle.dumps(self._job)
        token = hashlib.sha256(job).hexdigest()
        while True:
            while len(under_way) < self._room():
                chunk = again.popleft() if again else _Chunk(list(islice(waiting, self._chunk)))
                if not chunk.tasks:
                    break
                run = _run_guarded if chunk.is_suspect else _run_chunk
                future = self._client.submit(run, token, job, chunk.tasks, pure=False)
                under_way[future] = chunk
                future.add_done_callback(self._over.put)
            if not under_way:
                return
            future = self._finished()
            yield from self._take(future, under_way.pop(future), again)

    def _room(self) -> int:
        return UNDER_WAY * max(1, len(self._client.nthreads()))

    def _finished(self) -> Any:
        """One that is over.

        Raises:
            RunError: the scheduler is gone.
        """
        while True:
            if self._client.status != "running":
                raise RunError(_LOST)
            try:
                return self._over.get(timeout=_LOOK_SECONDS)
            except Empty:
                continue

    def _take(self, future: Any, chunk: _Chunk, again: deque[_Chunk]) -> Iterator[RunResult]:
        if future.status == "finished":
            yield from future.result()
            return
        if future.status in {"cancelled", "lost"}:
            again.append(chunk)
            return
        error = future.exception()
        if not isinstance(error, self._dask.KilledWorker):
            raise RunError(f"A worker of the cluster failed: {error}") from error
        if not chunk.is_suspect:
            again.append(_Chunk(chunk.tasks, is_suspect=True))
            return
        if len(chunk.tasks) > 1:
            again.extend(_Chunk([task], is_suspect=True) for task in chunk.tasks)
            return
        (task,) = chunk.tasks
        message = "The workers that ran it died again and again."
        yield RunResult(task.number, task.key, task.point, "crashed", message)


def _silence(*packages: str) -> None:
    """Let these packages log nothing; their modules' loggers have levels of their own."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in packages:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _run_chunk(token: str, job: bytes, tasks: list[Task]) -> list[RunResult]:
    """On a worker: run some points; simulations stay warm for the next chunk of the same sweep."""
    global _runner  # noqa: PLW0603 - one of each process
    with _lock:
        if _runner is None or _runner[0] != token:
            if _runner is not None:
                _runner[1].close()
            _runner = token, PointRunner(pickle.loads(job))
        return [_runner[1].run(task) for task in tasks]


def _run_guarded(token: str, job: bytes, tasks: list[Task]) -> list[RunResult]:
    """On a worker: run what may have killed others, in a process beside it."""
    del token
    with LocalPool(pickle.loads(job), 1) as pool:
        return list(pool.run(tasks))
