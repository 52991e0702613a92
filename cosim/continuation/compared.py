"""An earlier run's rows beside those of a run that goes on from it, or is the same again."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from cosim.base.errors import InputError, RunError
from cosim.base.recording import TextChanges
from cosim.master.assembly.clock import Clock
from cosim.record.reader import Run
from cosim.record.texts.recorded import RecordedText

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cosim.base.recording import RecordGroup, Rows
    from cosim.record.writer import Recorder

BLOCK_ROWS = 1024


class Compared:
    """A sink that begins with an earlier run's rows, and compares those that both runs have."""

    def __init__(self, recorder: Recorder, run: Run, first_tick: int) -> None:
        self._recorder, self._run, self._first = recorder, run, first_tick
        self._groups: Sequence[RecordGroup] = ()
        self._rows: dict[int, Rows] = {}
        self._last = 0
        self._different: tuple[int, str] | None = None
        self._texts: dict[tuple[int, int], TextChanges] = {}

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Begin the record with what there was before the first tick.

        Raises:
            InputError: the run recorded something else.
        """
        self._groups = groups
        if gone := set(self._run.groups) - {group.name for group in groups}:
            raise InputError(
                f"{self._run.folder} has the group {min(gone)} recorded, which this run has not."
            )
        for group in groups:
            there = self._run.groups.get(group.name)
            columns = {(each.name, each.unit or "", each.is_float) for each in group.columns}
            texts = {(each.name, each.is_binary) for each in group.texts}
            if (
                there is None
                or there.period != group.period
                or {(e.name, e.unit, e.is_float) for e in there.signals.values()} != columns
                or {(e.name, e.column.is_binary) for e in there.texts.values()} != texts
            ):
                raise InputError(
                    f"{self._run.folder} has something else recorded in the group {group.name}."
                )
        self._recorder.begin(groups, base_rate)
        for number, group in enumerate(groups):
            end = -(-self._first // group.period)
            for first in range(0, end, BLOCK_ROWS):
                last = min(first + BLOCK_ROWS, end)
                self._recorder.buffer(number, last - first)[:] = self._before(group, first, last)
                self._recorder.commit(number, first * group.period, last - first)
            for column, text in enumerate(group.texts):
                for tick, content in self._run.groups[group.name].texts[text.name].changes:
                    if tick < self._first:
                        self._recorder.put_text(number, column, tick, content)

    def buffer(self, group: int, rows: int) -> Rows:
        """The recorder's."""
        self._rows[group] = self._recorder.buffer(group, rows)
        return self._rows[group]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Compare what is new with what there was, and hand it over."""
        described = self._groups[group]
        first = first_tick // described.period
        last = min(first + rows, self._run.groups[described.name].rows)
        if first < last:
            self._compare(described, first, self._rows[group][: last - first])
            self._last = max(self._last, (last - 1) * described.period)
        self._recorder.commit(group, first_tick, rows)

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Keep a change for ``judge``, and hand it over."""
        self._texts.setdefault((group, column), TextChanges()).add(tick, content)
        self._recorder.put_text(group, column, tick, content)

    def judge(self, clock: Clock) -> None:
        """Whether both runs had the same rows.

        Raises:
            RunError: names the first signal that had another value, and when.
        """
        self._compare_texts()
        if self._different is not None:
            tick, name = self._different
            raise RunError(
                f"This run is not {self._run.folder}: {name} has another value at tick {tick} "
                f"(t = {clock.seconds(tick):g} s). Something that the numbers depend on has "
                "changed since."
            )

    def sentence(self) -> str:
        """What was found to be the same."""
        if self._last < self._first:
            return (
                f"It goes on where {self._run.folder} ended, so that there is nothing to compare."
            )
        return f"Ticks {self._first} to {self._last} are those of {self._run.folder}, bit for bit."

    def _compare_texts(self) -> None:
        for (group, column), changes in self._texts.items():
            described = self._groups[group]
            name = described.texts[column].name
            there = self._run.groups[described.name].texts[name]
            now = RecordedText(there.column, tuple(changes.changes))
            ticks = {tick for text in (there, now) for tick, _ in text.changes}
            ticks |= {-(-self._first // described.period) * described.period}
            for tick in sorted(ticks):
                if self._first <= tick <= self._last and there.at(tick) != now.at(tick):
                    if self._different is None or tick < self._different[0]:
                        self._different = tick, name
                    break

    def _before(self, group: RecordGroup, first: int, last: int) -> NDArray[np.int64]:
        signals = self._run.groups[group.name].signals
        found = [signals[column.name].cells(first, last) for column in group.columns]
        return np.stack(found, axis=1)

    def _compare(self, group: RecordGroup, first: int, rows: Rows) -> None:
        differs = self._before(group, first, first + len(rows)) != rows
        if differs.any():
            row = int(differs.any(axis=1).argmax())
            tick = (first + row) * group.period
            if self._different is None or tick < self._different[0]:
                self._different = tick, group.columns[int(differs[row].argmax())].name
