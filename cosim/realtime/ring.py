"""A ring of records in shared memory: the loop writes, recorder, console and live view read.

One writer, any number of readers in other processes, no lock: a slow reader loses the oldest
records and is told how many, and never holds up the loop. Each record carries its own number before
and after its cells, so that a reader notices one that was overwritten while it looked. The memory
is a mapped file, so that what was written survives a loop that was killed.
"""

from __future__ import annotations

import contextlib
import mmap
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cosim.realtime.shared.shared_file import hold, new_file

_HEAD_CELLS = 8
_MAGIC = 0x636F68617074


class Ring:
    """``capacity`` records of ``cells`` doubles each; the writer creates, readers attach."""

    def __init__(self, path: Path, *, read_only: bool = False) -> None:
        self.path = path
        self._held: int | None = None
        with path.open("rb" if read_only else "r+b") as file:
            if path.stat().st_size < 8 * _HEAD_CELLS:
                raise FileNotFoundError(f"{path} is no ring of ours")
            access = mmap.ACCESS_READ if read_only else mmap.ACCESS_WRITE
            self._memory = mmap.mmap(file.fileno(), 0, access=access)
        head = np.frombuffer(self._memory, np.int64, _HEAD_CELLS)
        self.capacity, self.cells = int(head[2]), int(head[3])
        size = 8 * (_HEAD_CELLS + self.capacity * (self.cells + 2))
        plausible = self.capacity > 0 and self.cells > 0 and size == len(self._memory)
        if int(head[0]) != _MAGIC or head[1] < 0 or not plausible:
            raise FileNotFoundError(f"{path} is no ring of ours")
        self.head = head
        self._cells = memoryview(self._memory).cast("q")
        body = np.frombuffer(self._memory, np.int64, offset=8 * _HEAD_CELLS)
        records = body.reshape(self.capacity, self.cells + 2)
        self.before, self.after = records[:, 0], records[:, -1]
        """Each record's number; -1 while it is being written."""
        self.values: NDArray[np.float64] = records[:, 1:-1].view(np.float64)
        """Shape (capacity, cells)."""

    @classmethod
    def create(
        cls,
        cells: int,
        capacity: int = 4096,
        path: Path | None = None,
        *,
        what: str = "a ring of values",
    ) -> Self:
        """A new ring, in memory where the system has a place for that.

        Raises:
            RunError: there is no room for it there; ``what`` says for what.
        """
        empty = np.full(_HEAD_CELLS + capacity * (cells + 2), -1, np.int64)
        empty[:4] = (_MAGIC, 0, capacity, cells)
        if path is not None:
            path.write_bytes(empty.tobytes())
            return cls(path)
        ring = cls(new_file(empty.tobytes(), what))
        ring._held = hold(ring.path)
        return ring

    @property
    def written(self) -> int:
        """Records written so far."""
        return int(self.head[1])

    def write(self, values: Sequence[float] | NDArray[np.float64]) -> None:
        """Append one record of ``cells`` doubles."""
        number = int(self.head[1])
        place = number % self.capacity
        self.before[place] = -1
        self.values[place] = values
        self.after[place] = number
        self.before[place] = number
        self.head[1] = number + 1

    def extend(self, rows: NDArray[np.int64]) -> None:
        """Append records of ``cells`` 8-byte cells each, shape (n, cells or fewer), as they are."""
        number, rows = int(self.head[1]), np.asarray(rows)
        skipped = max(0, len(rows) - self.capacity)
        numbers = np.arange(number + skipped, number + len(rows))
        places = numbers % self.capacity
        self.before[places] = -1
        # A record has at least one cell, also of rows that have none.
        self.values.view(np.int64)[places, : rows.shape[1]] = rows[skipped:]
        self.after[places] = numbers
        self.before[places] = numbers
        self.head[1] = number + len(rows)

    def put(self, cells: memoryview) -> None:
        """Append one record of ``cells`` 8-byte cells, as they are (format ``q``)."""
        memory = self._cells
        number = memory[1]
        first = _HEAD_CELLS + (number % self.capacity) * (self.cells + 2)
        last = first + self.cells + 1
        memory[first] = -1
        memory[first + 1 : last] = cells
        memory[last] = number
        memory[first] = number
        memory[1] = number + 1

    def newest(self, tries: int = 100) -> NDArray[np.float64] | None:
        """The last whole record, shape (cells,); ``None`` before the first one."""
        for _ in range(tries):
            number = self.written - 1
            if number < 0:
                return None
            place = number % self.capacity
            cells = self.values[place].copy()
            if int(self.before[place]) == number == int(self.after[place]):
                return cells
        return None

    def close(self) -> None:
        """Let go of the mapping."""
        if self._held is not None:
            os.close(self._held)
            self._held = None
        self._cells.release()
        del self.head, self.before, self.after, self.values
        with contextlib.suppress(BufferError):
            self._memory.close()

    def remove(self) -> None:
        """Let go, and remove the file; who is attached can still read."""
        self.close()
        self.path.unlink(missing_ok=True)


class Reader:
    """Reads a ring from now on, or from its oldest record."""

    def __init__(self, ring: Ring, *, oldest: bool = False) -> None:
        self._ring = ring
        self._next = max(0, ring.written - ring.capacity) if oldest else ring.written
        self.lost = 0
        """Records that were overwritten before they were read."""

    @property
    def position(self) -> int:
        """Number of the record that is read next."""
        return self._next

    def read(self, most: int = 1_000_000) -> NDArray[np.float64]:
        """The new records, oldest first: shape (n, cells), n up to ``most``."""
        ring = self._ring
        end = min(ring.written, self._next + most)
        first = min(max(self._next, ring.written - ring.capacity), end)
        numbers = np.arange(first, end)
        rows = numbers % ring.capacity
        values = ring.values[rows]
        # Looked at after the cells: what was overwritten meanwhile has another number by now.
        whole = (ring.before[rows] == numbers) & (ring.after[rows] == numbers)
        self.lost += (end - self._next) - int(whole.sum())
        self._next = end
        return values[whole]

    def close(self) -> None:
        """Let go of the ring."""
        self._ring.close()
