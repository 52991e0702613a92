"""Whether an FMU is as its sources are, told without reading them where nothing has changed.

In a working copy the sources are digested; what was found fresh is remembered with the size and the
times of every file that it could depend on, so that the next process only looks at those.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

from cosim.base import meaning
from cosim.base.errors import InputError
from cosim.base.quantities import units
from cosim.base.system.store import keep, recall
from fmus.cache import cache_directory
from fmus.names import FOLDER

SETTLED = 2.0
"""Seconds after which a file that is written again has another time for certain."""


def refuse_stale(name: str, path: Path) -> None:
    """Refuse the FMU at ``path`` of one of our models where it is not of the sources that are here.

    Raises:
        InputError: it is missing, or older than its sources.
    """
    kept = cache_directory() / "fresh" / hashlib.sha256(str(path).encode()).hexdigest()
    state = _state(name, path)
    if state is not None and recall(kept) == state:
        return
    _compare(name, path)
    newest = max((changed for _, _, changed in state.values()), default=0) if state else 0
    if state is not None and newest < (time.time() - SETTLED) * 1e9:
        keep(kept, state)


def _compare(name: str, path: Path) -> None:
    from fmus.builder import read_note, source_digest, source_of

    remedy = f"build it with 'uv sync' or 'uv run cohaptic fmu build {name}'."
    note = read_note(name)
    if note is None or not path.is_file():
        raise InputError(f"The FMU of '{name}' has not been built; {remedy}")
    if note["digest"] != source_digest(source_of(name)):
        raise InputError(f"The FMU of '{name}' is older than its sources; {remedy}")


def _state(name: str, path: Path) -> dict[str, tuple[int, int, int]] | None:
    """Size and times (ns) of each file by its path; ``None`` where one is missing."""
    own = (path, path.with_name(f"{name}.json"), Path(units.__file__), Path(meaning.__file__))
    try:
        found = {str(file): _times(file.stat()) for file in own}
        return found | {entry.path: _times(entry.stat()) for entry in _sources(FOLDER)}
    except OSError:
        return None


def _times(stat: os.stat_result) -> tuple[int, int, int]:
    return stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns


def _sources(folder: str | Path) -> Iterator[os.DirEntry[str]]:
    """Every C and Python file under a folder of ours, but nothing that was built."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                if not entry.name.startswith(("_", ".")):
                    yield from _sources(entry.path)
            elif entry.name.endswith((".c", ".h", ".py")):
                yield entry
