"""What an export format is given: signals that share their rows, in pieces that fit in memory."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal, Values

Span = tuple[int, int | None]
"""Base ticks from the first to the one after the last; without that to the end."""


@dataclass(frozen=True, slots=True)
class Table:
    """Signals that share their rows; ``period`` is in base ticks."""

    name: str
    run: Run
    period: int
    rows: int
    signals: tuple[RecordedSignal, ...]
    skipped: int = 0
    """Rows before the first one."""

    def ticks(self, first: int, last: int) -> NDArray[np.int64]:
        """Base ticks of rows ``first`` to ``last``."""
        return np.arange(self.skipped + first, self.skipped + last, dtype=np.int64) * self.period

    def within(self, span: Span) -> Table:
        """The rows whose ticks are in a span."""
        begin, end = span
        first = -(-max(begin, 0) // self.period)
        last = self.rows if end is None else min(self.rows, -(-end // self.period))
        return replace(self, skipped=first, rows=max(0, last - first))

    def values(self, signal: RecordedSignal, first: int, last: int) -> Values:
        """A signal's values in rows ``first`` to ``last``, held where it is slower."""
        if signal.group.period == self.period:
            return signal[self.skipped + first : self.skipped + last]
        rows = self.ticks(first, last) // signal.group.period
        return signal[int(rows[0]) : int(rows[-1]) + 1][rows - rows[0]]

    def pieces(self) -> Iterator[tuple[int, int]]:
        """Ranges of rows that fit into memory whatever the number of signals."""
        size = max(1, (1 << 20) // (len(self.signals) + 2))
        for first in range(0, self.rows, size):
            yield first, min(first + size, self.rows)


def needed(kind: str, module: str) -> Any:
    """Import what a format needs and a plain installation does not have.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        raise InputError(
            f"{kind} needs the package {package}: install cohaptic[export], or pip install "
            f"{package}."
        ) from None
