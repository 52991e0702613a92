"""A sink for a loop that must not share its process with a busy thread.

Rows go into a plain file beside the record, a batch at a time, and into the record itself after the
loop. A process that is killed leaves ``run.spool``: rows of each batch as int64 cells, after a head
of group, first tick, rows and columns.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from errno import ENOSPC
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.errors import RunError
from cosim.master.recording import RecordGroup
from cosim.record.writer import Recorder

SPOOL_FILE = "run.spool"
BATCH = 32
"""Rows of a group that are written at once: some tens of microseconds each 31 ms at 1024 Hz."""
_HEAD = struct.Struct("<qqqq")


class Spool:
    """A ``Sink`` in front of a :class:`Recorder`; call :meth:`drain` once the loop is over."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._path = Path(SPOOL_FILE)
        self._file: int | None = None
        self._batches: list[NDArray[np.int64]] = []
        self._first: list[int] = []
        self._used: list[int] = []

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Begin the record, and open the spool beside it.

        Raises:
            RunError: one of them cannot be created.
        """
        self._recorder.begin(groups, base_rate)
        self._path = self._recorder.path.with_name(SPOOL_FILE)
        try:
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        except OSError as error:
            raise self._refusal(error) from error
        self._batches = [np.zeros((BATCH, len(group.columns)), np.int64) for group in groups]
        self._first = [0] * len(groups)
        self._used = [0] * len(groups)

    def buffer(self, group: int, rows: int) -> NDArray[np.int64]:
        """Room for the next rows, shape (rows, columns)."""
        if self._used[group] + rows > self._batches[group].shape[0]:
            self._write(group)
        if rows > self._batches[group].shape[0]:
            self._batches[group] = np.zeros((rows, self._batches[group].shape[1]), np.int64)
        used = self._used[group]
        return self._batches[group][used : used + rows]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Take what ``buffer`` gave."""
        if rows and self._used[group] == 0:
            self._first[group] = first_tick
        self._used[group] += rows

    def drain(self) -> None:
        """Hand everything over to the recorder and remove the spool."""
        if self._file is None:
            return
        for group in range(len(self._batches)):
            self._write(group)
        file, self._file = self._file, None
        with os.fdopen(file, "rb") as spool:
            spool.seek(0)
            while head := spool.read(_HEAD.size):
                group, first, rows, columns = _HEAD.unpack(head)
                cells = np.frombuffer(spool.read(8 * rows * columns), np.int64)
                self._recorder.buffer(group, rows)[:] = cells.reshape(rows, columns)
                self._recorder.commit(group, first, rows)
        self._path.unlink(missing_ok=True)

    def _write(self, group: int) -> None:
        used = self._used[group]
        if used == 0 or self._file is None:
            return
        batch = self._batches[group]
        head = _HEAD.pack(group, self._first[group], used, batch.shape[1])
        try:
            written = os.writev(self._file, [head, batch[:used].data])
            if written != len(head) + 8 * used * batch.shape[1]:
                raise self._refusal(OSError(ENOSPC, os.strerror(ENOSPC)))
        except OSError as error:
            raise self._refusal(error) from error
        self._used[group] = 0

    def _refusal(self, error: OSError) -> RunError:
        return RunError(
            f"{self._path}: the record cannot be written ({error.strerror}). What was written "
            "before can be read. Free some space, or put the run elsewhere with --out."
        )
