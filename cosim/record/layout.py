"""The HDF5 file of a run: laid out in full before the run, filled with plain writes during it.

HDF5 lays the file out (every dataset, its attributes and its storage) and closes it. From then on
the file is valid: the writer puts values at their byte offsets with ordinary writes, and last the
number of rows that are complete. So a killed process leaves a file that every HDF5 reader opens,
and no HDF5 code runs while the loop runs. See docs/decisions/200-run-file.md.

::

    /                 attributes: format, base_rate [numerator, denominator] in Hz, meanings (1:
                      signals that mean something say so; missing in records of 0.1.0)
    /<group>          one per rate; attributes: period (base ticks), rate [numerator, denominator]
    /<group>/rows     int64 scalar: the rows that are complete
    /<group>/tick     int64 (rows,): base tick of each row
    /<group>/<signal> float64 or int64 (rows,); attributes: name, unit, causality, and where
                      there are any: description, items (JSON, names of an enumeration),
                      meaning (docs/fmus.md) with the peer and the finger that it is of
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import Column, RecordGroup
from cosim.record.hdf5 import h5py

FORMAT_VERSION = 1
HDF5_VERSION = "v110"
"""Oldest HDF5 library that reads the file: 1.10, for its small index of a dataset's chunks."""

SEGMENT_ROWS = 65536
MAX_SEGMENTS = 256
FRAME_BYTES = 1 << 16
COLUMN_FRAME_BYTES = 2048
"""Bound on what HDF5 itself needs for one dataset with its attributes."""
CELL_BYTES = 8


@dataclass(frozen=True, slots=True)
class GroupLayout:
    """Where a group's cells live in the file.

    A column's rows are stored in segments of ``segment`` rows (HDF5 chunks); ``offsets`` has shape
    (1 + columns, segments) and holds each segment's first byte, row 0 being the ticks'.
    ``rows_offset`` is the byte where the number of complete rows stands.
    """

    capacity: int
    segment: int
    offsets: NDArray[np.int64]
    rows_offset: int


def rows_in(ticks: int, period: int) -> int:
    """How many multiples of ``period`` there are in ticks 0 … ``ticks`` - 1."""
    return -(-ticks // period)


def dataset_name(signal: str) -> str:
    """The name of a signal's dataset; ``/`` would make a group, and an FMI name may contain it."""
    return signal.replace("/", "\N{DIVISION SLASH}")


def lay_out(
    path: Path, groups: Sequence[RecordGroup], base_rate: Fraction, capacities: Sequence[int]
) -> list[GroupLayout]:
    """Create the file with room for ``capacities`` rows of each group, and say where it is.

    No value is written: storage is reserved, and stays a hole in the file (on file systems that
    have holes) until the writer fills it.

    Raises:
        OSError: the file cannot be created, or there is no space for its frame.
    """
    _try_for_space(path, groups, capacities)
    with h5py().File(path, "w", libver=(HDF5_VERSION, HDF5_VERSION)) as file:
        file.attrs["format"] = np.int64(FORMAT_VERSION)
        file.attrs["meanings"] = np.int64(1)
        file.attrs["base_rate"] = np.array(base_rate.as_integer_ratio(), np.int64)
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
    texts = sum(len(column.description) for group in groups for column in group.columns)
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
    segment = max(1, min(capacity, max(SEGMENT_ROWS, -(-capacity // MAX_SEGMENTS))))
    segments = -(-capacity // segment)

    node = file.create_group(group.name, track_order=True)
    node.attrs["period"] = np.int64(group.period)
    node.attrs["rate"] = np.array((base_rate / group.period).as_integer_ratio(), np.int64)

    hdf = h5py()
    early = hdf.h5p.create(hdf.h5p.DATASET_CREATE)
    early.set_alloc_time(hdf.h5d.ALLOC_TIME_EARLY)
    scalar = hdf.h5s.create(hdf.h5s.SCALAR)
    rows = hdf.h5d.create(node.id, b"rows", hdf.h5t.STD_I64LE, scalar, early)
    early.set_chunk((segment,))
    early.set_fill_time(hdf.h5d.FILL_TIME_NEVER)
    space = hdf.h5s.create_simple((min(capacity, segment),), (hdf.h5s.UNLIMITED,))

    def create(name: str, *, is_float: bool) -> Any:
        cell = hdf.h5t.IEEE_F64LE if is_float else hdf.h5t.STD_I64LE
        return hdf.h5d.create(node.id, name.encode(), cell, space, early)

    datasets = [create("tick", is_float=False)]
    for column in group.columns:
        datasets.append(create(dataset_name(column.name), is_float=column.is_float))
        _describe(hdf.Dataset(datasets[-1]), column)

    # Segment by segment, so that what a short run leaves unused lies at the file's end.
    offsets = np.empty((len(datasets), segments), np.int64)
    for index in range(segments):
        for row, dataset in enumerate(datasets):
            if index:
                dataset.set_extent((min(capacity, (index + 1) * segment),))
            offsets[row, index] = dataset.get_chunk_info_by_coord((index * segment,)).byte_offset
    return GroupLayout(capacity, segment, offsets, rows.get_offset())


def _describe(dataset: Any, column: Column) -> None:
    dataset.attrs["name"] = column.name
    dataset.attrs["unit"] = column.unit or ""
    dataset.attrs["causality"] = column.causality
    if column.description:
        dataset.attrs["description"] = column.description
    if column.items:
        dataset.attrs["items"] = json.dumps({str(value): name for value, name in column.items})
    if column.meaning is not None:
        dataset.attrs["meaning"] = column.meaning.value
        slot = column.belongs_to
        for what, number in (("peer", slot.peer), ("finger", slot.finger)):
            if number is not None:
                dataset.attrs[what] = np.int64(number)
