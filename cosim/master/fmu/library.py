"""Libraries of FMUs that are open, each once in a process."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from cosim.master.fmu import fmi2, fmi3, state
from cosim.master.fmu.binding import Library


@cache
def open_library(path: Path, version: int) -> Library:
    """The library at ``path``, opened once; it stays loaded, since instances share it.

    Raises:
        InputError: it cannot be loaded, or lacks a function.
    """
    bound, saving = (fmi2, state.FMI2) if version == 2 else (fmi3, state.FMI3)
    return Library(path, {**bound.PROTOTYPES, **saving.prototypes()}, bound.NEEDED)
