"""Libraries of FMUs that are open, each once in a process."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from cosim.master.fmu import fmi2, fmi3
from cosim.master.fmu.binding import Library


@cache
def open_library(path: Path, version: int) -> Library:
    """The library at ``path``, opened once; it stays loaded, since instances share it.

    Raises:
        InputError: it cannot be loaded, or lacks a function.
    """
    return Library(path, fmi2.PROTOTYPES if version == 2 else fmi3.PROTOTYPES)
