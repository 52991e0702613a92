"""Recorded texts in other formats: a row for each change, in every format beside the numbers.

Binary data is written as base64, which every one of them can hold.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.record.export.table import Span
from cosim.record.reader import Run
from cosim.record.texts.recorded import RecordedText


@dataclass(frozen=True, slots=True)
class ChangeTable:
    """The changes of a group's texts, the earliest first."""

    name: str
    run: Run
    rows: tuple[tuple[int, str, str], ...]
    """Base tick, signal and value."""

    @property
    def ticks(self) -> NDArray[np.int64]:
        """The base tick of each row."""
        return np.array([tick for tick, _, _ in self.rows], dtype=np.int64)

    @property
    def signals(self) -> list[str]:
        """The signal of each row."""
        return [signal for _, signal, _ in self.rows]

    @property
    def values(self) -> list[str]:
        """The value of each row from its tick on."""
        return [value for _, _, value in self.rows]


def text_tables(run: Run, names: Collection[str], span: Span) -> list[ChangeTable]:
    """One for each group that has texts of these names, with the changes in a span of ticks.

    Where a span begins between two changes, its first row says what was held there.
    """
    found: list[ChangeTable] = []
    for name, group in run.groups.items():
        texts = [text for text in group.texts.values() if text.name in names]
        rows = [row for text in texts for row in _rows(text, span, run.ticks)]
        if rows:
            ordered = tuple(sorted(rows, key=lambda row: row[:2]))
            found.append(ChangeTable(f"{name}_texts", run, ordered))
    return found


def _rows(text: RecordedText, span: Span, ticks: int) -> Iterator[tuple[int, str, str]]:
    begin, end = max(span[0], 0), ticks if span[1] is None else min(ticks, span[1])
    held: bytes | None = None
    inside: list[tuple[int, bytes]] = []
    for tick, content in text.changes:
        if tick <= begin:
            held = content
        elif tick < end:
            inside.append((tick, content))
    if held is not None and begin < end:
        inside.insert(0, (begin, held))
    return ((tick, text.name, shown(text, content)) for tick, content in inside)


def shown(text: RecordedText, content: bytes) -> str:
    """A value as text: that of a Binary as base64."""
    return b64encode(content).decode() if text.column.is_binary else content.decode()
