"""What installed packages register and which version they are, searched no further than is due.

``importlib.metadata`` reads and parses what every package registers, which takes as long as putting
a scenario together. Here the files are looked into first; it is asked where they name the group,
and where packages may lie elsewhere than in folders.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def registered(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group, of every package on the path."""
    if _only_folders() and not any(_names(info, f"[{group}]".encode()) for info in _infos()):
        return ()
    from importlib.metadata import entry_points

    return tuple(entry_points(group=group))


def version_of(package: str) -> str | None:
    """The version of an installed package; ``None`` where there is none of that name."""
    wanted = _normal(package)
    for info in _infos():
        if info.suffix == ".dist-info" and _normal(info.name.partition("-")[0]) == wanted:
            try:
                head = (info / "METADATA").read_text(encoding="utf-8").partition("\n\n")[0]
            except OSError:
                continue
            if written := re.search(r"^Version: *(\S+)", head, re.MULTILINE):
                return written[1]
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()


def _only_folders() -> bool:
    """Whether every package lies in a folder of the path, unzipped and unpacked."""
    others = [f for f in sys.meta_path if f is not PathFinder and hasattr(f, "find_distributions")]
    return not others and not any(
        Path(place).is_file() or place.endswith(".egg") for place in sys.path
    )


def _infos() -> Iterator[Path]:
    """The folder of each installed package's metadata."""
    for place in sys.path:
        try:
            members = list(Path(place).iterdir())
        except OSError:
            continue
        yield from (each for each in members if each.name.endswith((".dist-info", ".egg-info")))


def _names(info: Path, group: bytes) -> bool:
    try:
        return group in (info / "entry_points.txt").read_bytes()
    except OSError:
        return False
