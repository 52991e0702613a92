"""A mapped file in memory that the processes of one run share, and nobody sweeps away meanwhile."""

from __future__ import annotations

import contextlib
import mmap
import os
import sys
from pathlib import Path
from typing import Self

from cosim.base.system.room import new_shared_file

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


def new_file(content: bytes, what: str) -> Path:
    """A file with that content, in memory where the system has a place for that.

    Raises:
        RunError: there is no room for it; ``what`` says for what.
    """
    return new_shared_file(content, what, PREFIX)


class SharedFile:
    """One, mapped; who is forked has it as well."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with path.open("r+b") as file:
            self.memory = mmap.mmap(file.fileno(), 0)
        self._held = hold(path)

    @classmethod
    def create(cls, content: bytes, what: str) -> Self:
        """A new one with that content.

        Raises:
            RunError: there is no room for it; ``what`` says for what.
        """
        return cls(new_file(content, what))

    def remove(self) -> None:
        """Let go, and remove the file."""
        if self._held is not None:
            os.close(self._held)
            self._held = None
        with contextlib.suppress(BufferError):
            self.memory.close()
        self.path.unlink(missing_ok=True)
