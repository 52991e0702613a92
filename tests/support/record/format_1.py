"""A record as version 0.1.0 wrote it: a dataset for each signal, and no meanings."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import RecordGroup


def write_format_1(
    folder: Path, group: RecordGroup, cells: NDArray[np.int64], rate: Fraction, *, spare: int = 0
) -> None:
    """Write ``cells``, shape (rows, columns), with room for ``spare`` rows more."""
    folder.mkdir()
    room = np.zeros(spare, np.int64)
    with h5py.File(folder / "run.h5", "w", libver=("v110", "v110")) as file:
        file.attrs["format"] = np.int64(1)
        file.attrs["base_rate"] = np.array(rate.as_integer_ratio(), np.int64)
        node = file.create_group(group.name, track_order=True)
        node.attrs["period"] = np.int64(group.period)
        node.attrs["rate"] = np.array((rate / group.period).as_integer_ratio(), np.int64)
        node["rows"] = np.int64(len(cells))
        node["tick"] = np.concatenate([group.period * np.arange(len(cells)), room])
        for column, values in zip(group.columns, cells.T, strict=True):
            kind = np.float64 if column.is_float else np.int64
            name = column.name.replace("/", "\N{DIVISION SLASH}")
            node[name] = np.concatenate([values, room]).view(kind)
            attributes = node[name].attrs
            attributes["name"], attributes["unit"] = column.name, column.unit or ""
            attributes["causality"] = column.causality
            if column.description:
                attributes["description"] = column.description
            if column.items:
                attributes["items"] = json.dumps({str(v): item for v, item in column.items})
