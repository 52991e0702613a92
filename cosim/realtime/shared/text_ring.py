"""Texts from the loop's process to the recorder's: a ring of bytes in shared memory.

Each change of a text is a frame: group, column, tick and length, then its bytes. One writer, one
reader, no lock: the writer moves ``written`` on when a frame is whole, the reader ``read`` when it
has it. Where there is no room the writer waits for nobody: it keeps the newest of each text for
itself, and hands it over when there is. So the last value of every text arrives, with its own tick;
changes between that were skipped are counted.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Self

import numpy as np

from cosim.realtime.shared.shared_file import SharedFile

CAPACITY = 8 << 20
"""Bytes; a longer text waits for the end of the run."""
_FRAME = struct.Struct("<iiqq")
_HEAD_BYTES = 64
_WRITTEN, _READ, _SKIPPED = range(3)

Change = tuple[int, int, int, bytes]
"""Group, column, the base tick since which it is so, and what it is then."""


class TextRing:
    """The memory; made before the loop's process is forked, which has it, too."""

    def __init__(self, file: SharedFile) -> None:
        self._file = file
        self._head = np.frombuffer(file.memory, np.int64, _HEAD_BYTES // 8)
        self._bytes = memoryview(file.memory)[_HEAD_BYTES:]
        self._capacity = len(self._bytes)
        self._pending: dict[tuple[int, int], tuple[int, bytes]] = {}

    @classmethod
    def create(cls, capacity: int = CAPACITY) -> Self:
        """A new one.

        Raises:
            RunError: there is no room for it.
        """
        content = bytes(_HEAD_BYTES + capacity)
        return cls(SharedFile.create(content, "the texts on their way to the record"))

    @property
    def skipped(self) -> int:
        """Changes that were followed by others before there was room for them."""
        return int(self._head[_SKIPPED])

    def put(self, group: int, column: int, tick: int, content: bytes) -> None:
        """The writer: hand a change over as soon as there is room."""
        if self._pending:
            self.flush()
        key = group, column
        if key in self._pending:
            self._head[_SKIPPED] += 1
        elif self._write(group, column, tick, content):
            return
        self._pending[key] = tick, content

    def flush(self) -> None:
        """The writer: hand over what waits, as far as there is room."""
        for (group, column), (tick, content) in list(self._pending.items()):
            if not self._write(group, column, tick, content):
                return
            del self._pending[group, column]

    @property
    def has_pending(self) -> bool:
        """The writer: whether something waits."""
        return bool(self._pending)

    def rest(self) -> list[Change]:
        """The writer: what still waits when the loop is over."""
        return [(*key, *change) for key, change in self._pending.items()]

    def read(self) -> Iterator[Change]:
        """The reader: what has come, oldest first."""
        end = int(self._head[_WRITTEN])
        at = int(self._head[_READ])
        while at < end:
            group, column, tick, size = _FRAME.unpack(self._part(at, _FRAME.size))
            content = self._part(at + _FRAME.size, size)
            at += _FRAME.size + size
            self._head[_READ] = at
            yield group, column, tick, content

    def remove(self) -> None:
        """Let go, and remove the file."""
        del self._head
        self._bytes.release()
        self._file.remove()

    def _write(self, group: int, column: int, tick: int, content: bytes) -> bool:
        written = int(self._head[_WRITTEN])
        size = _FRAME.size + len(content)
        if size > self._capacity - (written - int(self._head[_READ])):
            return False
        self._place(written, _FRAME.pack(group, column, tick, len(content)))
        self._place(written + _FRAME.size, content)
        self._head[_WRITTEN] = written + size
        return True

    def _place(self, at: int, data: bytes) -> None:
        begin = at % self._capacity
        first = min(len(data), self._capacity - begin)
        self._bytes[begin : begin + first] = data[:first]
        self._bytes[: len(data) - first] = data[first:]

    def _part(self, at: int, size: int) -> bytes:
        begin = at % self._capacity
        first = min(size, self._capacity - begin)
        return bytes(self._bytes[begin : begin + first]) + bytes(self._bytes[: size - first])
