"""Recorded rows from the loop's process to the recorder's, through a ring a record group.

Texts go through a ring of their own (``shared/text_ring``).

The loop's side is what the master calls a sink; the recorder's side feeds any other sink. Rows keep
their bits. A recorder that cannot keep up never holds up the loop: rows that were overwritten
before they were read are counted, and recorded as held.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import RecordGroup, Sink
from cosim.realtime.ring import Reader, Ring
from cosim.realtime.shared.text_ring import TextRing

SECONDS = 8.0
"""How far a recorder may fall behind the loop."""


class RelaySink:
    """The loop's side: one row at a time (a paced loop runs tick by tick)."""

    def __init__(
        self, rings: Sequence[Ring], groups: Sequence[RecordGroup], texts: TextRing | None = None
    ) -> None:
        self._put = [ring.put for ring in rings]
        whole = [np.zeros((1, ring.cells), np.int64) for ring in rings]
        self._cells = [memoryview(rows[0]).cast("B").cast("q") for rows in whole]
        self._rows = [
            rows[:, : len(group.columns)] for rows, group in zip(whole, groups, strict=True)
        ]
        self._texts = texts

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """The recorder knows the groups already."""

    def buffer(self, group: int, rows: int) -> NDArray[np.int64]:
        """Room for the next row."""
        if rows != 1:
            message = "a paced loop records one row at a time"
            raise ValueError(message)
        return self._rows[group]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Hand the row on."""
        del first_tick
        if rows:
            self._put[group](self._cells[group])
        if self._texts is not None and self._texts.has_pending:
            self._texts.flush()

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Hand a change on."""
        assert self._texts is not None, "there is a ring where texts are recorded"
        self._texts.put(group, column, tick, content)


class RelayPump:
    """The recorder's side: call :meth:`pump` until the loop is over, and once more then."""

    def __init__(
        self,
        rings: Sequence[Ring],
        groups: Sequence[RecordGroup],
        sink: Sink,
        texts: TextRing | None = None,
    ) -> None:
        self._readers = [Reader(ring, oldest=True) for ring in rings]
        self._groups, self._sink = groups, sink
        self._texts = texts
        self._rows = [0] * len(rings)
        self._held = [np.zeros((1, ring.cells), np.int64) for ring in rings]
        self.lost = 0
        """Rows that the recorder was too slow for."""

    def pump(self) -> int:
        """Hand on what has come; the tick after the last row that is in."""
        reached = 0
        for number, (reader, group) in enumerate(zip(self._readers, self._groups, strict=True)):
            before = reader.lost
            values = reader.read().view(np.int64)
            lost = reader.lost - before
            if lost:
                self.lost += lost
                self._hand_on(number, group, np.repeat(self._held[number], lost, axis=0))
            if len(values):
                self._held[number] = values[-1:].copy()
                self._hand_on(number, group, values)
            reached = max(reached, self._rows[number] * group.period)
        for change in self._texts.read() if self._texts is not None else ():
            self._sink.put_text(*change)
        return reached

    @property
    def skipped(self) -> int:
        """Changes of texts that the recorder was too slow for."""
        return 0 if self._texts is None else self._texts.skipped

    def _hand_on(self, number: int, group: RecordGroup, rows: NDArray[np.int64]) -> None:
        room = self._sink.buffer(number, len(rows))
        room[:] = rows[:, : room.shape[1]]
        first = self._rows[number] * group.period
        self._rows[number] += len(rows)
        self._sink.commit(number, first, len(rows))


def make_rings(groups: Sequence[RecordGroup], rate: Fraction) -> list[Ring]:
    """A ring for each record group of a scenario with that base rate (Hz).

    Raises:
        RunError: there is no room for all of them; then there is none.
    """
    with ExitStack() as undone:
        rings: list[Ring] = []
        for group in groups:
            capacity = max(64, int(SECONDS * float(rate) / group.period))
            what = f"the rows of {group.name} on their way to the record"
            rings.append(Ring.create(max(1, len(group.columns)), capacity, what=what))
            undone.callback(rings[-1].remove)
        undone.pop_all()
    return rings


def make_text_ring(groups: Sequence[RecordGroup]) -> TextRing | None:
    """The ring of a scenario's texts, where some are recorded."""
    return TextRing.create() if any(group.texts for group in groups) else None
