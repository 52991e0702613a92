"""A mapped file in memory that the processes of one run share, and nobody sweeps away meanwhile."""

from __future__ import annotations

import contextlib
import mmap
import os
import sys
import tempfile
from pathlib import Path
from typing import Self

if sys.platform != "win32":
    import fcntl

PREFIX = "cohaptic-ring-"
"""How such files begin."""


def hold(path: Path) -> int | None:
    """Keep a file from being swept away, for as long as a process of this run lives.

    The number of the open file that does so, where the system can.
    """
    if sys.platform == "win32":
        return None
    held = os.open(path, os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_SH)
    return held


def new_path() -> Path:
    """An empty file, in memory where the system has a place for that."""
    shared = Path("/dev/shm")
    folder = shared if shared.is_dir() else Path(tempfile.gettempdir())
    descriptor, name = tempfile.mkstemp(prefix=PREFIX, dir=folder)
    os.close(descriptor)
    return Path(name)


class SharedFile:
    """One, mapped; who is forked has it as well."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with path.open("r+b") as file:
            self.memory = mmap.mmap(file.fileno(), 0)
        self._held = hold(path)

    @classmethod
    def create(cls, content: bytes) -> Self:
        """A new one with that content.

        Raises:
            OSError: there is no room for it.
        """
        path = new_path()
        try:
            path.write_bytes(content)
            return cls(path)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def remove(self) -> None:
        """Let go, and remove the file."""
        if self._held is not None:
            os.close(self._held)
            self._held = None
        with contextlib.suppress(BufferError):
            self.memory.close()
        self.path.unlink(missing_ok=True)
