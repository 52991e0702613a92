"""Runs of known cells, written by the real recorder."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cosim.base.recording import RecordGroup
from cosim.record.writer import Recorder

Cells = NDArray[np.int64]
RATE = Fraction(1024)


def write(
    path: Path,
    groups: Sequence[RecordGroup],
    cells: Sequence[Cells],
    *,
    rows_at_a_time: Iterable[int] = (),
    ticks: int | None = None,
    base_rate: Fraction = RATE,
    start_tick: int = 0,
) -> Recorder:
    """Record each group's cells, shape (rows, columns), in pieces of the given sizes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    planned = max(len(block) * group.period for group, block in zip(groups, cells, strict=True))
    recorder = Recorder(path, planned if ticks is None else ticks, start_tick)
    recorder.begin(groups, base_rate)
    for index, (group, block) in enumerate(zip(groups, cells, strict=True)):
        done, pieces = 0, iter(rows_at_a_time)
        while done < len(block):
            count = min(next(pieces, 1000), len(block) - done)
            recorder.buffer(index, count)[:] = block[done : done + count]
            recorder.commit(index, done * group.period, count)
            done += count
    recorder.close()
    return recorder


@contextmanager
def small_disk(folder: Path, size: str) -> Iterator[None]:
    """``folder`` as a file system of its own; skips where that needs more rights."""
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("mounting a small file system needs root")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)
