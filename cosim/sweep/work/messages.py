"""Tasks and results on their way between a pool and a worker: small, and quick to read.

Both are the same Python, so plain values travel as ``marshal`` has them. Names of measures go once;
from then on a result has their number. What the pool knows of a task does not come back.
"""

from __future__ import annotations

import marshal
from typing import Any

from cosim.sweep.job import RunResult, Task

READY = b""
"""A worker has read the scenario."""
_Names = tuple[tuple[str, ...], tuple[str, ...]]


def task_bytes(task: Task) -> bytes:
    """What a worker is told."""
    return marshal.dumps((task.number, task.point))


def task_of(data: bytes) -> Task:
    """What it is to run."""
    return Task(*marshal.loads(data))


class ResultWriter:
    """A worker's side."""

    def __init__(self) -> None:
        self._numbers: dict[_Names, int] = {}

    def write(self, result: RunResult) -> bytes:
        """A result in bytes."""
        names = tuple(result.measures), tuple(result.passed)
        head: Any = self._numbers.get(names)
        if head is None:
            self._numbers[names] = len(self._numbers)
            head = names
        # Nothing but Python's own numbers: those of NumPy would travel as bytes.
        values = [v if type(v) is int else float(v) for v in result.measures.values()]
        passed = [bool(met) for met in result.passed.values()]
        rest = result.status, result.message, int(result.ticks), float(result.seconds)
        return marshal.dumps((head, values, passed, *rest, bool(result.checked)))


class ResultReader:
    """A pool's side, of one worker."""

    def __init__(self) -> None:
        self._names: list[_Names] = []

    def read(self, data: bytes, task: Task) -> RunResult:
        """The result of a task."""
        head, values, passed, status, message, ticks, seconds, checked = marshal.loads(data)
        if not isinstance(head, int):
            self._names.append(head)
            head = -1
        measures, expected = self._names[head]
        return RunResult(
            task.number,
            task.key,
            task.point,
            status,
            message,
            dict(zip(measures, values, strict=True)),
            dict(zip(expected, passed, strict=True)),
            ticks,
            seconds,
            checked,
        )
