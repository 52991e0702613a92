"""What killed runs have left in shared memory: rings, and descriptions of runs, that nobody has.

A ring is locked (flock) by the processes of its run, and freed with the last of them, even a killed
one. A description names the process that wrote it.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl

RINGS, FEEDS = "cohaptic-ring-*", "cohaptic-live-*"
OLD_SECONDS = 3600.0
"""A ring that no description names may still be one that is about to be described."""


def remove_leftovers(folder: Path) -> int:
    """Remove them; the bytes that are free now. What belongs to others stays."""
    freed = 0
    for path in list(leftovers(folder)):
        with suppress(OSError):
            size = path.stat().st_size
            path.unlink()
            freed += size
    return freed


def leftovers(folder: Path) -> Iterator[Path]:
    """The files of runs that are over."""
    described: set[Path] = set()
    for feed in folder.glob(FEEDS):
        if _is_alive(feed):
            continue
        yield feed
        with suppress(OSError, ValueError, KeyError, TypeError):
            content = json.loads(feed.read_text("utf-8"))
            described |= {Path(group["ring"]) for group in content["groups"]}
    for ring in folder.glob(RINGS):
        with suppress(OSError):
            is_old = time.time() - ring.stat().st_mtime > OLD_SECONDS
            if (is_old or ring in described) and not _is_held(ring):
                yield ring


def _is_alive(feed: Path) -> bool:
    """Whether the process that a description's name begins with is still there."""
    number = feed.name.removeprefix("cohaptic-live-").partition("-")[0]
    if not number.isdecimal():
        return True
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _is_held(ring: Path) -> bool:
    if sys.platform == "win32":
        return True
    with ring.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return True
    return False
