"""Which processor a loop takes: one that no other loop has, and of those the least used.

A claim is a lock on a small file that every user may open, so that two loops that start together
do not choose the same one; it ends with the process.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from cosim.base.system.room import shared_folder

if sys.platform != "win32":
    import fcntl

LOOK_SECONDS = 0.05
"""For how long the processors' use is observed."""

_claims: list[int] = []
"""Locked files of this process; closed by its end and by nothing else."""


def claim(processors: Sequence[int], folder: Path | None = None) -> int | None:
    """Claim the least used of some processors; ``None`` where others have claimed them all."""
    used = _use()
    for processor in sorted(processors, key=lambda number: (used.get(number, 0.0), -number)):
        lock = _lock(processor, folder or shared_folder())
        if lock is not None:
            _claims.append(lock)
            return processor
    return None


def release() -> None:
    """Give up what this process has claimed."""
    while _claims:
        os.close(_claims.pop())


def _lock(processor: int, folder: Path) -> int | None:
    """The locked file, or ``None`` where another has it; what cannot be had locks nothing."""
    if sys.platform == "win32":
        return None
    path = folder / f"cohaptic-processor-{processor}"
    try:
        file = os.open(path, os.O_RDWR)
    except OSError:
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            with contextlib.suppress(OSError):
                os.fchmod(file, 0o666)
        except OSError:
            return os.open(os.devnull, os.O_RDONLY)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(file)
        return None
    return file


def _use() -> dict[int, float]:
    """Share of the last moment in which each processor was busy; empty where nobody says."""
    first = _times()
    if not first:
        return {}
    time.sleep(LOOK_SECONDS)
    found: dict[int, float] = {}
    for number, (busy, total) in _times().items():
        before = first.get(number, (0, 0))
        # In steps of a tenth: what is less apart than that is equally used.
        share = (busy - before[0]) / max(1, total - before[1])
        found[number] = round(share, 1)
    return found


def _times() -> dict[int, tuple[int, int]]:
    """Jiffies that each processor was busy, and all of them (proc(5): user, nice, system, idle)."""
    found: dict[int, tuple[int, int]] = {}
    with contextlib.suppress(OSError, ValueError):
        for line in Path("/proc/stat").read_bytes().decode().splitlines():
            name, *numbers = line.split()
            if name.startswith("cpu") and name != "cpu":
                jiffies = [int(number) for number in numbers[:8]]
                found[int(name[3:])] = (sum(jiffies) - jiffies[3] - jiffies[4], sum(jiffies))
    return found
