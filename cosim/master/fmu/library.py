"""Libraries of FMUs that are open: one for all instances of a run, a fresh one for the next run.

What a library keeps in static memory outlives its instances, and few FMUs were tried a second time
in one process. So a foreign library is unloaded and loaded again where a run takes one that an
earlier run gave back; where the system does not let go of it, a private copy is loaded instead.
"""

from __future__ import annotations

import _ctypes
import atexit
import ctypes
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.master.fmu import fmi2, fmi3, state
from cosim.master.fmu.binding import Library


@dataclass(slots=True)
class _Open:
    library: Library
    users: int = 0
    was_used: bool = False
    is_lost: bool = False
    """Something of it was never freed: it cannot be unloaded."""


_OPEN: dict[tuple[Path, int], _Open] = {}


def take_library(path: Path, version: int, *, renew: bool = True) -> Library:
    """The library at ``path``; everybody who takes it at a time shares it.

    Without ``renew`` it stays loaded for good: it keeps nothing in static memory.

    Raises:
        InputError: it cannot be loaded, or lacks a function.
    """
    found = _OPEN.get((path, version))
    if found is None:
        found = _OPEN[path, version] = _Open(_load(path, version))
    elif renew and found.was_used and not found.users:
        found = _OPEN[path, version] = _Open(_renewed(path, version, found))
    found.users += 1
    found.was_used = True
    return found.library


def give_back(path: Path, version: int, *, lost: bool = False) -> None:
    """An instance is gone; ``lost``: without having been freed."""
    found = _OPEN[path, version]
    found.users -= 1
    found.is_lost = found.is_lost or lost


def _load(path: Path, version: int) -> Library:
    bound, saving = (fmi2, state.FMI2) if version == 2 else (fmi3, state.FMI3)
    return Library(path, {**bound.PROTOTYPES, **saving.prototypes()}, bound.NEEDED)


def _renewed(path: Path, version: int, used: _Open) -> Library:
    if not used.is_lost and _unload(used.library):
        return _load(used.library.path, version)  # a lost one stays loaded at `path`
    return _load(_copy(path), version)


def _unload(library: Library) -> bool:
    """Whether nothing of it is left in this process."""
    if not hasattr(os, "RTLD_NOLOAD"):
        return False
    unload: Any = _ctypes.dlclose  # pyright: ignore[reportAttributeAccessIssue, reportUnknownVariableType, reportUnknownMemberType]
    unload(library.handle)
    try:
        left = ctypes.CDLL(str(library.path), mode=os.RTLD_NOLOAD)
    except OSError:
        return True
    unload(left._handle)
    return False


def _copy(path: Path) -> Path:
    """In a folder of this process, with the libraries beside it."""
    folder = Path(tempfile.mkdtemp(prefix="cohaptic-library-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(shutil.copytree(path.parent, folder / path.parent.name)) / path.name
