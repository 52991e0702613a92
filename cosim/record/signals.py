"""Recorded signals, their groups and times; values are read when they are asked for."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column
from cosim.record.statistics import ColumnStatistics, ColumnSummary
from cosim.record.stores import GroupStore
from cosim.record.texts.recorded import RecordedText

Values = NDArray[np.float64] | NDArray[np.int64]


BLOCK_ROWS = 8192
"""Rows read at once by what goes through a whole record; a few seconds at 1024 Hz."""


class RecordTimes:
    """Of one record."""

    def __init__(self, base_rate: Fraction, start_tick: int) -> None:
        self.base_rate = base_rate
        """Base ticks a second (Hz)."""
        self.start_tick = start_tick
        """How many base ticks after time 0 the first one is."""
        self._timed: tuple[NDArray[np.int64] | None, NDArray[np.float64]] = None, np.zeros(0)

    def seconds(self, ticks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Times (s) of base ticks: one division by the base rate, so rounded once."""
        if ticks is self._timed[0]:
            return self._timed[1]
        rate = self.base_rate
        since_0 = (ticks + self.start_tick) * rate.denominator
        seconds = np.divide(since_0, rate.numerator, dtype=np.float64)
        if not ticks.flags.writeable:  # they stay what they are
            self._timed = ticks, seconds
        return seconds


class SignalGroup:
    """Signals recorded at one rate. ``name`` is the rate's; ``period`` is in base ticks."""

    def __init__(self, times: RecordTimes, name: str, store: GroupStore) -> None:
        self.times = times
        self.name = name
        self.period = store.period
        self.rows = store.rows
        self.capacity = store.capacity
        """Rows that the file has room for; more than ``rows`` where a run was cut off."""
        self._store = store

    @property
    def rate(self) -> Fraction:
        """Rows a second (Hz)."""
        return self.times.base_rate / self.period

    @cached_property
    def signals(self) -> Mapping[str, RecordedSignal]:
        """The group's signals by name, in the order in which they were recorded."""
        return Signals(
            self._store.names, lambda name: RecordedSignal(self, *self._store.place(name))
        )

    @cached_property
    def texts(self) -> Mapping[str, RecordedText]:
        """The group's Strings and Binaries by name, as far as its rows are complete."""
        end = self.rows * self.period
        return MappingProxyType({text.name: text.before(end) for text in self._store.texts()})

    @property
    def ticks(self) -> NDArray[np.int64]:
        """Base tick of every row, shape (rows,), read from the file at each call."""
        return self.ticks_of(0, self.rows)

    def ticks_of(self, start: int, stop: int) -> NDArray[np.int64]:
        """Base ticks of rows ``start`` to ``stop``; only those are read."""
        return self._store.ticks(start, min(stop, self.rows))

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of every row (s), shape (rows,): the tick counted from 0 s over the base rate."""
        return self.times.seconds(self.ticks)

    def first_row_at(self, tick: int) -> int:
        """The first row whose tick is ``tick`` or later; ``rows`` if there is none."""
        if self._is_regular:
            return min(max(-(-tick // self.period), 0), self.rows)
        ticks = self._store.ticks
        return bisect_left(range(self.rows), tick, key=lambda row: int(ticks(row, row + 1)[0]))

    def covers(self, first: int, last: int) -> bool:
        """Whether all rows there are lie within ``first`` <= tick < ``last``."""
        return self.first_row_at(first) == 0 and self.first_row_at(last) == self.rows

    @cached_property
    def _is_regular(self) -> bool:
        """Whether row i is that of tick i · period: rows come in order, a period apart at least."""
        if self.rows == 0:
            return True
        first, last = (int(self._store.ticks(row, row + 1)[0]) for row in (0, self.rows - 1))
        return first == 0 and last == (self.rows - 1) * self.period

    def pieces(self, start: int = 0, stop: int | None = None) -> Iterator[tuple[int, int]]:
        """Rows ``start`` to ``stop`` cut into ranges, so that a long run need not fit in memory."""
        last = self.rows if stop is None else stop
        for first in range(start, last, BLOCK_ROWS):
            yield first, min(first + BLOCK_ROWS, last)


class RecordedSignal:
    """One recorded variable: float64, or int64 for integers, booleans and enumerations."""

    def __init__(self, group: SignalGroup, column: Column, dataset: Any, row: int | None) -> None:
        self.group = group
        self.column = column
        """What the master said about it when it was recorded."""
        self._dataset = dataset
        self._row = row

    @property
    def name(self) -> str:
        """Component and variable."""
        return self.column.name

    @property
    def unit(self) -> str:
        """The FMI unit string; empty where the variable has none."""
        return self.column.unit or ""

    @property
    def meaning(self) -> Meaning | None:
        """What the signal means to those that look for it."""
        return self.column.meaning

    @property
    def belongs_to(self) -> Slot:
        """The peer and the finger whose it is."""
        return self.column.belongs_to

    @property
    def description(self) -> str:
        """What the component says about the variable."""
        return self.column.description

    @property
    def is_float(self) -> bool:
        """Whether the values are float64; otherwise they are int64."""
        return self.column.is_float

    @property
    def values(self) -> Values:
        """All values, shape (rows,), read from the file at each call."""
        return self[:]

    def __getitem__(self, rows: slice) -> Values:
        """Some rows; only those are read.

        Raises:
            InputError: the run was closed.
            TypeError: it is no slice.
        """
        if not isinstance(rows, slice):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"{self.name}: rows are read by a slice, such as [0:10], not {rows!r}.")
        wanted = range(*rows.indices(self.group.rows))
        if not wanted:
            return self._read(slice(0, 0))
        if wanted.step < 0:
            return self._read(slice(wanted[-1], wanted[0] + 1, -wanted.step))[::-1]
        return self._read(slice(wanted.start, wanted.stop, wanted.step))

    def _read(self, rows: slice) -> Values:
        try:
            found = self._dataset[rows if self._row is None else (self._row, rows)]
        except (OSError, ValueError):
            if isinstance(self._dataset, np.ndarray) or self._dataset:
                raise
            raise InputError(f"{self.name}: the run that it is of was closed.") from None
        return cast("Values", found)

    def cells(self, start: int, stop: int) -> NDArray[np.int64]:
        """Rows ``start`` to ``stop`` as raw cells: an int64, or the bits of a float64."""
        return self[start:stop].view(np.int64)

    def blocks(self, start: int = 0, stop: int | None = None) -> Iterator[Values]:
        """The values of rows ``start`` to ``stop``, piece by piece."""
        for first, last in self.group.pieces(start, stop):
            yield self[first:last]

    def summary(self) -> ColumnSummary:
        """Statistics and envelope, from one pass over the file."""
        statistics = ColumnStatistics(np.array([self.is_float]), max(1, self.group.rows))
        for block in self.blocks():
            statistics.update(np.ascontiguousarray(block).view(np.int64)[None])
        return statistics.summary(0)


class Signals(Mapping[str, RecordedSignal]):
    """Signals by name; each is made when it is first asked for."""

    def __init__(self, names: Iterable[str], make: Callable[[str], RecordedSignal]) -> None:
        self._names = dict.fromkeys(names)
        self._make = make
        self._made: dict[str, RecordedSignal] = {}

    def __getitem__(self, name: str) -> RecordedSignal:
        if name not in self._made:
            if name not in self._names:
                raise KeyError(name)
            self._made[name] = self._make(name)
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
