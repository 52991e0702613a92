"""The table of a group's signals: what each one is, and where its values lie."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column
from cosim.record.hdf5 import h5py

TABLE = "signals"
Entry = tuple[Any, ...]
"""A row of the table as it is in the file."""
_MEANINGS = frozenset(Meaning)
FLOATS, INTEGERS = "float64", "int64"
"""The datasets of values, named after what they hold."""


def dataset_of(column: Column) -> str:
    """The dataset that a column's values are in."""
    return FLOATS if column.is_float else INTEGERS


def write_table(group: Any, columns: Sequence[Column]) -> None:
    """Create the table of ``group`` (an HDF5 group), a row for each column in its order."""
    text = h5py().string_dtype()
    texts = ("name", "unit", "type", "causality", "description", "items", "meaning")
    numbers = ("peer", "finger", "row")
    kinds = np.dtype([*((name, text) for name in texts), *((name, np.int64) for name in numbers)])
    rows = {FLOATS: 0, INTEGERS: 0}
    table = np.empty(len(columns), kinds)
    for number, column in enumerate(columns):
        place = dataset_of(column)
        items = json.dumps({str(value): name for value, name in column.items})
        table[number] = (
            column.name,
            column.unit or "",
            place,
            column.causality,
            column.description,
            items if column.items else "",
            str(column.meaning or ""),
            column.belongs_to.peer or 0,
            column.belongs_to.finger or 0,
            rows[place],
        )
        rows[place] += 1
    group.create_dataset(TABLE, data=table)


def read_names(group: Any) -> list[str]:
    """The name of every column of ``group``, in the order in which they were written."""
    return [name.decode() for name in group[TABLE].fields("name")[()].tolist()]


def entry_at(group: Any, number: int) -> Entry:
    """The entry of one column."""
    return group[TABLE][number].tolist()


def entries_of(group: Any) -> list[Entry]:
    """Every entry, read at once, and understood where somebody asks for it (``read_entry``)."""
    return group[TABLE][()].tolist()


def read_entry(entry: Entry) -> tuple[Column, str, int]:
    """A column with its dataset and its row there."""
    parts: list[Any] = [part.decode() if isinstance(part, bytes) else part for part in entry]
    name, unit, place, causality, description, items, meaning, peer, finger, row = parts
    named: dict[str, str] = json.loads(items) if items else {}
    column = Column(
        name=name,
        unit=unit or None,
        is_float=place == FLOATS,
        description=description,
        causality=causality,
        items=tuple((int(value), item) for value, item in named.items()),
        # A later version may know more.
        meaning=Meaning(meaning) if meaning in _MEANINGS else None,
        belongs_to=Slot(peer or None, finger or None),
    )
    return column, place, int(row)
