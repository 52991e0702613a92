"""A run that ended early, rewritten without the room that it did not need."""

from __future__ import annotations

import shutil
from io import FileIO
from pathlib import Path

import numpy as np

from cosim.base.recording import RecordGroup
from cosim.record.layout import CELL_BYTES, GroupLayout, lay_out, write_cells
from cosim.record.reader import Run, open_run
from cosim.record.signals import SignalGroup

SPARE_BYTES = 64 << 20
"""What the file system keeps free: a record must not take the last of it for tidiness."""


def compact(path: Path) -> bool:
    """Cut the datasets of ``path`` (a ``run.h5``) to their complete rows.

    Readers that know nothing of cohaptic then see no row that was never reached. The file is
    written anew beside the old one and takes its place in one step. Returns whether it did:
    not where nothing was to be cut, nor where there is no space for the copy.

    Raises:
        OSError: the copy failed; the file is as it was.
    """
    copy = path.with_suffix(".compact")
    with open_run(path) as run:
        if all(group.rows == group.capacity for group in run.groups.values()):
            return False
        needed = sum(
            (len(group.signals) + 1) * group.rows * CELL_BYTES for group in run.groups.values()
        )
        if shutil.disk_usage(path.parent).free < needed + SPARE_BYTES:
            return False
        try:
            _copy(run, copy)
        except OSError:
            copy.unlink(missing_ok=True)
            raise
    copy.replace(path)
    return True


def _copy(run: Run, copy: Path) -> None:
    groups = tuple(run.groups.values())
    plan = [
        RecordGroup(
            name=group.name,
            period=group.period,
            columns=tuple(signal.column for signal in group.signals.values()),
        )
        for group in groups
    ]
    rows = [group.rows for group in groups]
    layouts = lay_out(copy, plan, run.base_rate, rows, run.start_tick)
    with copy.open("r+b", buffering=0) as file:
        for group, layout in zip(groups, layouts, strict=True):
            _copy_group(group, layout, file)


def _copy_group(group: SignalGroup, layout: GroupLayout, file: FileIO) -> None:
    readers = [group.ticks_of, *(signal.cells for signal in group.signals.values())]
    for read, offsets in zip(readers, layout.offsets, strict=True):
        for segment, offset in enumerate(offsets.tolist()):
            first = segment * layout.segment
            write_cells(file, offset, read(first, min(first + layout.segment, group.rows)))
    write_cells(file, layout.rows_offset, np.array([group.rows]))
