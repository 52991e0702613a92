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
    if version == 2:
        return Library(path, fmi2.PROTOTYPES, state.FMI2.prototypes())
    return Library(path, fmi3.PROTOTYPES, state.FMI3.prototypes())
