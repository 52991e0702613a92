"""What the master hands to a recorder: groups of columns, and blocks of rows.

A group holds the signals recorded every ``period`` ticks; row i of a group belongs to tick
``i * period``. A row is one 8-byte cell a column: a double, or an int64 where ``is_float`` is
false.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.meaning import NO_SLOT, Meaning, Slot

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One recorded signal: ``component.variable``, with ``[i]`` for an element of an array."""

    name: str
    unit: str | None
    is_float: bool
    description: str = ""
    causality: str = "output"
    items: tuple[tuple[int, str], ...] = ()
    """Names of an enumeration's values."""
    meaning: Meaning | None = None
    """What the signal means to those that look for it."""
    belongs_to: Slot = NO_SLOT
    """The peer and the finger whose it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TextColumn:
    """One recorded String or Binary, of which changes are kept, each with its tick."""

    name: str
    is_binary: bool
    description: str = ""
    causality: str = "output"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordGroup:
    """The columns that are recorded together, every ``period`` ticks; texts are in no row."""

    name: str
    period: int
    columns: tuple[Column, ...]
    texts: tuple[TextColumn, ...] = ()


class Sink(Protocol):
    """Takes the rows of a run. Called from the loop's thread: must be quick."""

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Told once, before the first row."""
        ...

    def buffer(self, group: int, rows: int) -> Rows:
        """Room for the next rows of a group: int64, shape (rows, columns), C order.

        The kernel fills it, possibly only in part; it must stay valid until ``commit``.
        """
        ...

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """The first ``rows`` rows of the last buffer of this group are filled.

        ``first_tick`` is the tick of the first of them.
        """
        ...

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """A text of a group (UTF-8, or the bytes of a Binary) as it is from a tick on."""
        ...


class TextChanges:
    """The changes of one text; what stays as it was is none."""

    def __init__(self) -> None:
        self.changes: list[tuple[int, bytes]] = []

    def add(self, tick: int, content: bytes) -> None:
        """The text at a tick, which is no earlier than the last one."""
        if not self.changes or self.changes[-1][1] != content:
            self.changes.append((tick, content))


class Forgetful:
    """Keeps nothing; for a part of a run that is run again."""

    def __init__(self, groups: Sequence[RecordGroup]) -> None:
        self._columns = [len(group.columns) for group in groups]

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Nothing to prepare."""

    def buffer(self, group: int, rows: int) -> Rows:
        """Room that is given back."""
        return np.empty((rows, self._columns[group]), dtype=np.int64)

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Nothing is kept."""

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Nothing is kept."""


_CELL = np.dtype(np.int64).itemsize
_MANY, _LARGE = 2**20, 2**22
"""Bytes of rows from which on room is taken by the second, for which NumPy asks for large pages: a
fault for each small one takes longer than the rows that it has room for."""


class MemorySink:
    """Keeps everything in memory; for tests, short runs and analysis.

    Where ``ticks`` says how long the run is, all rows of a group lie in one array from the start,
    and a sink that is used again for a run of the same length keeps its arrays.
    """

    def __init__(self, ticks: int | None = None) -> None:
        self._ticks = ticks
        self._arrays: list[Rows] = []
        self._filled: list[int] = []
        self._kept: tuple[int, MemorySink] | None = None
        self.groups: tuple[RecordGroup, ...] = ()
        self.base_rate = Fraction(1)
        self._blocks: list[list[Rows]] = []
        self._room: dict[int, Rows] = {}
        self._texts: list[list[TextChanges]] = []

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Forget what was recorded before."""
        if self._ticks is not None and (self.groups is not groups or not self._arrays):
            self._arrays = [
                np.zeros((-(-self._ticks // group.period), len(group.columns)), dtype=np.int64)
                for group in groups
            ]
        self.groups = tuple(groups)
        self.base_rate = base_rate
        self._blocks = [[] for _ in groups]
        self._room = {}
        self._filled = [0 for _ in groups]
        before = self._texts
        self._texts = [[TextChanges() for _ in group.texts] for group in groups]
        if self._kept is not None:
            tick, source = self._kept
            for number, group in enumerate(groups):
                rows = self._filled[number] = -(-tick // group.period)
                self._arrays[number][:rows] = source._arrays[number][:rows]
                kept = before if source is self else source._texts
                for changes, there in zip(self._texts[number], kept[number], strict=True):
                    changes.changes = [each for each in there.changes if each[0] < tick]

    def buffer(self, group: int, rows: int) -> Rows:
        """Rows that are not filled yet."""
        if self._arrays:
            return self._arrays[group][self._filled[group] : self._filled[group] + rows]
        room = self._room.get(group)
        if room is None or len(room) < rows:
            room = self._room[group] = self._more_room(group, rows)
        return room[:rows]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Keep the filled part; rows follow each other without a gap."""
        if first_tick != self._filled[group] * self.groups[group].period:
            raise AssertionError(f"rows of {self.groups[group].name} do not follow each other")
        self._filled[group] += rows
        if not self._arrays:
            room = self._room[group]
            self._blocks[group].append(room[:rows])
            self._room[group] = room[rows:]

    def _more_room(self, group: int, rows: int) -> Rows:
        """For as many rows as there are: what is not filled is not touched, and costs nothing."""
        width = len(self.groups[group].columns)
        count = max(rows, self._filled[group])
        if count * width * _CELL >= _MANY:
            count = max(count, -(-_LARGE // (width * _CELL)))
        return np.empty((count, width), dtype=np.int64)

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Keep a change."""
        self._texts[group][column].add(tick, content)

    def text(self, group: int, column: int) -> list[tuple[int, bytes]]:
        """The changes of a text: tick and content."""
        return self._texts[group][column].changes

    def keep(self, tick: int, source: MemorySink | None = None) -> None:
        """Keep the rows before a tick at the next ``begin``: those of ``source``, or its own.

        Only where ``ticks`` was given.
        """
        self._kept = tick, self if source is None else source

    def rows(self, group: int) -> Rows:
        """All rows of a group, shape (rows, columns)."""
        if self._arrays:
            return self._arrays[group][: self._filled[group]]
        width = len(self.groups[group].columns)
        return np.concatenate(self._blocks[group] or [np.zeros((0, width), dtype=np.int64)])

    def signal(self, name: str) -> NDArray[np.float64] | NDArray[np.int64]:
        """One recorded signal by name, shape (rows,).

        Raises:
            KeyError: it was not recorded.
        """
        for number, group in enumerate(self.groups):
            for index, column in enumerate(group.columns):
                if column.name == name:
                    cells = np.ascontiguousarray(self.rows(number)[:, index])
                    return cells.view(np.float64) if column.is_float else cells
        raise KeyError(name)
