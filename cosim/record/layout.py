"""The HDF5 file of a run: laid out in full before the run, filled with plain writes during it.

HDF5 lays the file out (every dataset, its attributes and its storage) and closes it. From then on
the file is valid: the writer puts values at their byte offsets with ordinary writes, and last the
number of rows that are complete. So a killed process leaves a file that every HDF5 reader opens,
and no HDF5 code runs while the loop runs. See docs/decisions/200-run-file.md.

::

    /                 attributes: format, base_rate [numerator, denominator] in Hz,
                      start_tick where tick 0 is not at time 0
    /<group>          one per rate; attributes: period (base ticks), rate [numerator, denominator]
    /<group>/rows     int64 scalar: the rows that are complete
    /<group>/tick     int64 (rows,): base tick of each row
    /<group>/signals  table: name, unit, type, causality, description, items (JSON, names of an
                      enumeration), meaning (docs/fmus.md) with the peer and the finger that it is
                      of (from 1, 0 for none), row
    /<group>/float64  float64 (signals of that type, rows): row ``row`` holds a signal's values
    /<group>/int64    int64 (signals of that type, rows)
"""

from __future__ import annotations

import errno
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import RecordGroup
from cosim.record.hdf5 import h5py
from cosim.record.table import FLOATS, INTEGERS, dataset_of, write_table

FORMAT_VERSION = 2
"""Format 1 had a dataset for each signal; it is read, and no longer written."""
HDF5_VERSION = "v110"
"""Oldest HDF5 library that reads the file: 1.10, for its small index of a dataset's chunks."""

SEGMENT_ROWS = 65536
MAX_SEGMENTS = 256
SEGMENT_BYTES = 1 << 31
"""Largest segment of a dataset; HDF5's own limit for a chunk is twice that."""
FRAME_BYTES = 1 << 16
COLUMN_FRAME_BYTES = 512
"""Bound on what HDF5 itself needs for one signal in the table, beside its texts."""
CELL_BYTES = 8


@dataclass(frozen=True, slots=True)
class GroupLayout:
    """Where a group's cells live in the file.

    A column's rows are stored in segments of ``segment`` rows, side by side in an HDF5 chunk with
    those of the other columns of its type; ``offsets`` has shape (1 + columns, segments) and holds
    each segment's first byte, row 0 being the ticks'.
    ``rows_offset`` is the byte where the number of complete rows stands.
    """

    capacity: int
    segment: int
    offsets: NDArray[np.int64]
    rows_offset: int


def rows_in(ticks: int, period: int) -> int:
    """How many multiples of ``period`` there are in ticks 0 … ``ticks`` - 1."""
    return -(-ticks // period)


def lay_out(
    path: Path,
    groups: Sequence[RecordGroup],
    base_rate: Fraction,
    capacities: Sequence[int],
    start_tick: int = 0,
) -> list[GroupLayout]:
    """Create the file with room for ``capacities`` rows of each group, and say where it is.

    Tick 0 is ``start_tick`` base ticks after time 0.

    No value is written: storage is reserved, and stays a hole in the file (on file systems that
    have holes) until the writer fills it.

    Raises:
        OSError: the file cannot be created, or there is no space for its frame.
    """
    _try_for_space(path, groups, capacities)
    with h5py().File(path, "w", libver=(HDF5_VERSION, HDF5_VERSION)) as file:
        file.attrs["format"] = np.int64(FORMAT_VERSION)
        file.attrs["base_rate"] = np.array(base_rate.as_integer_ratio(), np.int64)
        if start_tick:
            file.attrs["start_tick"] = np.int64(start_tick)
        return [
            _lay_out_group(file, group, base_rate, capacity)
            for group, capacity in zip(groups, capacities, strict=True)
        ]


def write_cells(file: FileIO, offset: int, cells: NDArray[np.int64]) -> None:
    """Write all of a contiguous array: a disk that fills up takes a part first and then refuses.

    Raises:
        OSError: the system refuses to write.
    """
    view = cells.data.cast("B")
    file.seek(offset)
    while view:
        view = view[file.write(view) :]


def _try_for_space(path: Path, groups: Sequence[RecordGroup], capacities: Sequence[int]) -> None:
    """Let the system refuse here: HDF5 itself ends the process when it cannot write on closing."""
    texts = sum(
        len(column.name) + len(column.description) + sum(len(name) + 16 for _, name in column.items)
        for group in groups
        for column in group.columns
    )
    frame = FRAME_BYTES + COLUMN_FRAME_BYTES * sum(len(group.columns) + 1 for group in groups)
    frame += 4 * texts
    data = sum(
        (len(group.columns) + 1) * CELL_BYTES * capacity
        for group, capacity in zip(groups, capacities, strict=True)
    )
    with path.open("wb", buffering=0) as file:
        file.truncate(frame + data)
        zeros = bytes(1 << 16)
        for _ in range(-(-frame // len(zeros))):
            if file.write(zeros) < len(zeros):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _lay_out_group(
    file: Any, group: RecordGroup, base_rate: Fraction, capacity: int
) -> GroupLayout:
    counts = Counter(dataset_of(column) for column in group.columns)
    widest = max([1, *counts.values()])
    longest = min(max(SEGMENT_ROWS, -(-capacity // MAX_SEGMENTS)), SEGMENT_BYTES // 8 // widest)
    segment = max(1, min(capacity, longest))
    segments = -(-capacity // segment)

    node = file.create_group(group.name, track_order=True)
    node.attrs["period"] = np.int64(group.period)
    node.attrs["rate"] = np.array((base_rate / group.period).as_integer_ratio(), np.int64)

    hdf = h5py()
    early = hdf.h5p.create(hdf.h5p.DATASET_CREATE)
    early.set_alloc_time(hdf.h5d.ALLOC_TIME_EARLY)
    scalar = hdf.h5s.create(hdf.h5s.SCALAR)
    rows = hdf.h5d.create(node.id, b"rows", hdf.h5t.STD_I64LE, scalar, early)
    early.set_fill_time(hdf.h5d.FILL_TIME_NEVER)
    write_table(node, group.columns)

    def create(name: str, *shape: int) -> Any:
        cell = hdf.h5t.IEEE_F64LE if name == FLOATS else hdf.h5t.STD_I64LE
        early.set_chunk((*shape, segment))
        limits = (*shape, hdf.h5s.UNLIMITED)
        space = hdf.h5s.create_simple((*shape, min(capacity, segment)), limits)
        return hdf.h5d.create(node.id, name.encode(), cell, space, early)

    ticks = create("tick")
    values = {name: create(name, counts[name]) for name in (FLOATS, INTEGERS) if counts[name]}

    # Segment by segment, so that what a short run leaves unused lies at the file's end.
    offsets = np.empty((1 + len(group.columns), segments), np.int64)
    for index in range(segments):
        reached = min(capacity, (index + 1) * segment)
        offsets[0, index] = _segment_of(ticks, (), index * segment, reached)
        first = {
            name: _segment_of(dataset, (counts[name],), index * segment, reached)
            for name, dataset in values.items()
        }
        for number, column in enumerate(group.columns):
            name = dataset_of(column)
            offsets[number + 1, index] = first[name]
            first[name] += segment * CELL_BYTES
    return GroupLayout(capacity, segment, offsets, rows.get_offset())


def _segment_of(dataset: Any, shape: tuple[int, ...], first: int, reached: int) -> int:
    """The byte where the segment begins whose first row is ``first``; the dataset grows to it."""
    if first:
        dataset.set_extent((*shape, reached))
    place = (*(0 for _ in shape), first)
    return int(dataset.get_chunk_info_by_coord(place).byte_offset)
