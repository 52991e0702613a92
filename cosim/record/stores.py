"""Where the rows of a group are: in a file, or in memory; the same reader takes both."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import Column, MemorySink
from cosim.record.old_meaning import old_meaning
from cosim.record.table import TABLE, Entry, entries_of, entry_at, read_entry, read_names
from cosim.record.texts.recorded import RecordedText

Place = tuple[Column, Any, int | None]
"""A signal, what its values are read from, and the row there that is the signal's."""


SINGLY = 4
"""Entries of a table that are read one by one: whoever asks for more asks for many."""


class GroupStore(Protocol):
    """The rows of one group."""

    period: int
    """Base ticks from row to row."""
    rows: int
    capacity: int
    """Rows that there is room for."""

    def ticks(self, start: int, stop: int) -> NDArray[np.int64]:
        """Base ticks of rows ``start`` to ``stop``, shape (stop - start,)."""
        ...

    @property
    def names(self) -> Collection[str]:
        """Every signal, in the order in which they were recorded."""
        ...

    def place(self, name: str) -> Place:
        """A signal, and where its values are."""
        ...

    def texts(self) -> Sequence[RecordedText]:
        """Every text with its changes."""
        ...


class FileStore:
    """A group of ``run.h5``, of any format."""

    def __init__(self, node: Any, texts: Callable[[], Sequence[RecordedText]]) -> None:
        self._texts = texts
        self.period = int(node.attrs["period"])
        self.rows = int(node["rows"][()])
        self.capacity = int(node["tick"].shape[0])
        self._node = node
        self._singly = 0

    def ticks(self, start: int, stop: int) -> NDArray[np.int64]:
        """Base ticks of rows ``start`` to ``stop``, shape (stop - start,)."""
        return self._node["tick"][start:stop]

    @property
    def names(self) -> Collection[str]:
        """Every signal, in the order in which they were recorded."""
        return self._numbers

    def place(self, name: str) -> Place:
        """A signal, and where its values are."""
        number = self._numbers[name]
        if TABLE not in self._node:
            return _described(self._datasets[number]), self._datasets[number], None
        self._singly += 1
        is_one = self._singly <= SINGLY
        entry = entry_at(self._node, number) if is_one else self._entries[number]
        column, place, row = read_entry(entry)
        return column, self._node[place], row

    @cached_property
    def _numbers(self) -> dict[str, int]:
        """The place of each signal among the entries of the table."""
        if TABLE in self._node:
            names = read_names(self._node)
        else:
            names = [str(dataset.attrs["name"]) for dataset in self._datasets]
        return {name: number for number, name in enumerate(names)}

    @cached_property
    def _entries(self) -> list[Entry]:
        return entries_of(self._node)

    @cached_property
    def _datasets(self) -> list[Any]:
        """Of format 1: one for each signal."""
        return [node for key, node in self._node.items() if key not in {"rows", "tick"}]

    def texts(self) -> Sequence[RecordedText]:
        """Every text with its changes, read from the folder."""
        return self._texts()


class MemoryStore:
    """A group that a ``MemorySink`` holds."""

    def __init__(self, sink: MemorySink, group: int) -> None:
        cells = sink.rows(group)
        self.period = sink.groups[group].period
        self.rows = self.capacity = len(cells)
        self._columns = sink.groups[group].columns
        self._cells = cells
        self._ticks: tuple[tuple[int, int], NDArray[np.int64]] | None = None
        """Those that were asked for last: every measure of a run asks for the same."""
        self._rows = {column.name: row for row, column in enumerate(self._columns)}
        self._texts = [
            RecordedText(column, tuple(sink.text(group, number)))
            for number, column in enumerate(sink.groups[group].texts)
        ]

    def ticks(self, start: int, stop: int) -> NDArray[np.int64]:
        """Base ticks of rows ``start`` to ``stop``, shape (stop - start,); not to be changed."""
        if self._ticks is None or self._ticks[0] != (start, stop):
            ticks = np.arange(start, stop, dtype=np.int64) * self.period
            ticks.flags.writeable = False
            self._ticks = (start, stop), ticks
        return self._ticks[1]

    @property
    def names(self) -> Collection[str]:
        """Every signal, in the order in which they were recorded."""
        return self._rows

    def place(self, name: str) -> Place:
        """A signal, and where its values are."""
        row = self._rows[name]
        column = self._columns[row]
        return column, (self._cells.view(np.float64) if column.is_float else self._cells).T, row

    def texts(self) -> Sequence[RecordedText]:
        """Every text with its changes."""
        return self._texts


def _described(dataset: Any) -> Column:
    """What a dataset of format 1 says about its signal."""
    attributes = dataset.attrs
    name = str(attributes["name"])
    items: dict[str, str] = json.loads(str(attributes.get("items", "{}")))
    meaning, slot = old_meaning(name)
    return Column(
        name=name,
        unit=str(attributes["unit"]) or None,
        is_float=dataset.dtype.kind == "f",
        description=str(attributes.get("description", "")),
        causality=str(attributes["causality"]),
        items=tuple((int(value), item) for value, item in items.items()),
        meaning=meaning,
        belongs_to=slot,
    )
