"""The recorder: takes rows from the loop and puts them into the run's file from a thread.

The loop fills cells in place in blocks from a bounded pool; a full block, or one older than
``FLUSH_SECONDS``, goes to the writer thread. When the disk is slower than the loop, the loop waits:
nothing is dropped and memory does not grow.
"""

from __future__ import annotations

import errno
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from io import FileIO
from pathlib import Path
from queue import SimpleQueue

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import RunError
from cosim.base.recording import RecordGroup
from cosim.record.layout import CELL_BYTES, GroupLayout, lay_out, rows_in, write_cells
from cosim.record.rewriting.compact import compact
from cosim.record.statistics import ColumnStatistics, ColumnSummary
from cosim.record.texts.journal import TextJournal

BLOCK_BYTES = 1 << 21
BLOCK_ROWS = (16, 4096)
BLOCKS = 3
FLUSH_SECONDS = 0.5


class Recorder:
    """A ``Sink`` that writes ``path``, with room for ``ticks`` base ticks.

    Tick 0 is ``start_tick`` base ticks after time 0.

    Use it as a context manager, or call ``close``. What has been flushed survives anything that
    happens to the process: see ``layout``.
    """

    def __init__(self, path: Path, ticks: int, start_tick: int = 0) -> None:
        self.path, self.ticks, self.start_tick = path, ticks, start_tick
        self.groups: tuple[RecordGroup, ...] = ()
        self.base_rate = Fraction(1)
        self.statistics: tuple[ColumnStatistics, ...] = ()
        self.drain_time = 0.0
        """How long the loop's end was ahead of the file (s), after ``close``."""
        self._begun = False
        self._streams: list[_Stream] = []
        self._full: SimpleQueue[_Block | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._error: RunError | None = None
        self._journal: TextJournal | None = None

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Lay the file out and start the writer.

        Raises:
            RunError: the file cannot be created.
        """
        rows = [rows_in(self.ticks, group.period) for group in groups]
        try:
            layouts = lay_out(self.path, groups, base_rate, rows, self.start_tick)
            if any(group.texts for group in groups):
                self._journal = TextJournal(self.path.parent, groups)
            file = self.path.open("r+b", buffering=0)
        except BaseException as error:  # also Ctrl-C: half a frame is no file
            with suppress(OSError):
                self.path.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise self.refusal(error) from error
            raise
        self.groups, self.base_rate = tuple(groups), base_rate
        self._streams = [
            _Stream(group, layout) for group, layout in zip(groups, layouts, strict=True)
        ]
        self.statistics = tuple(stream.statistics for stream in self._streams)
        self._begun = True
        self._thread = threading.Thread(
            target=self._write_blocks, args=(file,), name="recorder", daemon=True
        )
        self._thread.start()

    @property
    def has_begun(self) -> bool:
        """Whether there is a file to read, be it without rows."""
        return self._begun

    def buffer(self, group: int, rows: int) -> NDArray[np.int64]:
        """Room for the next ``rows`` rows of a group, shape (rows, columns), C order.

        A cell is an int64 or the bits of a float64. Waits while every block is being written.

        Raises:
            RunError: writing failed; what was flushed before can be read.
        """
        if self._error is not None:
            raise self._error
        stream = self._streams[group]
        block = stream.current
        if block is None or block.used + rows > block.cells.shape[0]:
            block = self._next_block(stream, rows)
        return block.cells[block.used : block.used + rows]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Hand over what ``buffer`` gave: ``rows`` rows, the first one of tick ``first_tick``."""
        if rows == 0:
            return
        block = self._streams[group].current
        assert block is not None
        now = time.monotonic()
        if block.used == 0:
            block.first_tick, block.since = first_tick, now
        block.used += rows
        if now - block.since > FLUSH_SECONDS:
            self._submit(self._streams[group])

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """A text of a group as it is from a tick on; it is in the folder at once.

        Raises:
            RunError: it cannot be written.
        """
        assert self._journal is not None
        try:
            self._journal.put(group, column, tick, content)
        except OSError as error:
            raise self.refusal(error) from error

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows of each group that are in the file; all that were committed, after ``close``."""
        return tuple(stream.written for stream in self._streams)

    def summaries(self) -> dict[str, ColumnSummary]:
        """Statistics and envelope of every signal, taken on the way; after ``close``.

        Of a signal recorded at several rates, those of the fastest.
        """
        found: dict[str, ColumnSummary] = {}
        order = sorted(zip(self.groups, self.statistics, strict=True), key=lambda g: -g[0].period)
        for group, statistics in order:
            found |= {
                column.name: statistics.summary(index) for index, column in enumerate(group.columns)
            }
        return found

    def close(self) -> None:
        """Write what is left, stop the thread and cut the file to what was reached.

        Raises:
            RunError: not everything could be written; what was flushed before can be read.
        """
        thread, self._thread = self._thread, None
        if thread is None:
            return
        for stream in self._streams:
            self._submit(stream)
        self._full.put(None)
        began = time.perf_counter()
        thread.join()
        self.drain_time = time.perf_counter() - began
        journal, self._journal = self._journal, None
        if self._error is not None:
            if journal is not None:
                journal.close()
            raise self._error
        try:
            compact(self.path)
            if journal is not None:
                journal.finish()
        except OSError as error:
            raise self.refusal(error) from error

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            self.close()
        except RunError:
            if kind is None:  # otherwise the error that ended the run says more
                raise

    def _next_block(self, stream: _Stream, rows: int) -> _Block:
        self._submit(stream)
        block = stream.free.get()
        if self._error is not None:
            raise self._error
        if rows > block.cells.shape[0]:
            block = _Block(stream, rows)
        block.used = 0
        stream.current = block
        return block

    def _submit(self, stream: _Stream) -> None:
        block, stream.current = stream.current, None
        if block is None:
            return
        (self._full if block.used else stream.free).put(block)

    def _write_blocks(self, file: FileIO) -> None:
        """The thread: write blocks in order until ``None``; after a failure only return them."""
        with file:
            while (block := self._full.get()) is not None:
                if self._error is None:
                    try:
                        block.stream.write(file, block)
                    except OSError as error:
                        self._error = self.refusal(error)
                    except Exception as error:  # a slip of ours: end the run, do not hang it
                        self._error = RunError(f"{self.path}: the recorder failed: {error!r}")
                        self._error.__cause__ = error
                block.stream.free.put(block)

    def refusal(self, error: OSError) -> RunError:
        """What the system would not write, as a sentence."""
        place = self.path
        if error.errno in {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}:
            return RunError(
                f"{place}: no space left for the record ({error.strerror}). What was written "
                "before can be read. Free some space, record fewer signals, or put the run "
                "elsewhere with --out."
            )
        return RunError(
            f"{place}: the record cannot be written ({error.strerror or error}). What was written "
            "before can be read. Put the run elsewhere with --out."
        )


class _Block:
    """Rows of one group on their way to the file."""

    __slots__ = ("cells", "first_tick", "since", "stream", "used")

    def __init__(self, stream: _Stream, rows: int) -> None:
        self.stream = stream
        self.cells = np.zeros((rows, stream.columns), np.int64)
        self.used = 0
        self.first_tick = 0
        self.since = 0.0


class _Stream:
    """One group: its pool of blocks, where its rows go in the file, and its statistics."""

    def __init__(self, group: RecordGroup, layout: GroupLayout) -> None:
        self.name, self.period, self.columns = group.name, group.period, len(group.columns)
        self.layout = layout
        self.written = 0
        self.statistics = ColumnStatistics(
            np.array([column.is_float for column in group.columns], np.bool_), layout.capacity
        )
        self.current: _Block | None = None
        self.free: SimpleQueue[_Block] = SimpleQueue()
        rows = max(1, BLOCK_BYTES // (CELL_BYTES * max(1, self.columns)))
        rows = min(max(rows, BLOCK_ROWS[0]), BLOCK_ROWS[1])
        for _ in range(BLOCKS):
            self.free.put(_Block(self, rows))
        self._turned = np.zeros((self.columns + 1, rows), np.int64)

    def write(self, file: FileIO, block: _Block) -> None:
        """Write a block column by column, then the number of rows, then take it into account."""
        rows = block.used
        if self.written + rows > self.layout.capacity:
            msg = f"group {self.name}: more rows than the {self.layout.capacity} laid out"
            raise OSError(errno.EFBIG, msg)
        if rows > self._turned.shape[1]:
            self._turned = np.zeros((self.columns + 1, rows), np.int64)
        turned = self._turned[:, :rows]
        turned[0] = block.first_tick + self.period * np.arange(rows)
        np.copyto(turned[1:], block.cells[:rows].T)
        self._write_rows(file, turned)
        done = self.written + rows
        write_cells(file, self.layout.rows_offset, np.array([done]))
        self.written = done
        self.statistics.update(turned[1:])

    def _write_rows(self, file: FileIO, cells: NDArray[np.int64]) -> None:
        """Put (1 + columns, rows) cells behind the rows written so far, segment by segment."""
        taken, rows = 0, cells.shape[1]
        while taken < rows:
            segment, row = divmod(self.written + taken, self.layout.segment)
            count = min(rows - taken, self.layout.segment - row)
            places = self.layout.offsets[:, segment] + row * CELL_BYTES
            for place, column in zip(places.tolist(), cells, strict=True):
                write_cells(file, place, column[taken : taken + count])
            taken += count
