"""Rows in binary logs: those that the master records, and those of a bare loop."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cosim.base.recording import MemorySink, Rows


class BinaryLog(MemorySink):
    """Writes rows as they are, a file a group."""

    def __init__(self, files: Sequence[Path]) -> None:
        super().__init__()
        self._files = [file.open("wb", buffering=0) for file in files]
        self._rows: dict[int, Rows] = {}

    def buffer(self, group: int, rows: int) -> Rows:
        """The same room again and again."""
        if group not in self._rows or len(self._rows[group]) < rows:
            self._rows[group] = np.zeros((rows, len(self.groups[group].columns)), dtype=np.int64)
        return self._rows[group][:rows]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Write them."""
        self._files[group].write(self._rows[group][:rows].data)

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()


class BareLog:
    """Files for ``fwrite``, one a group: what the bare loop calls, and with what."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._libc = ctypes.CDLL(None)
        self._libc.fopen.restype = ctypes.c_void_p
        self.fwrite = ctypes.cast(self._libc.fwrite, ctypes.c_void_p).value or 0
        self.streams = [self._libc.fopen(str(file).encode(), b"wb") for file in files]

    def close(self) -> None:
        """Write what is left, and close the files."""
        for stream in self.streams:
            self._libc.fclose(ctypes.c_void_p(stream))
