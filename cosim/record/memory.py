"""A run that was kept in memory, read as one from a file is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.recording import MemorySink
from cosim.record.reader import Run
from cosim.record.stores import MemoryStore


def run_in_memory(
    sink: MemorySink, manifest: Mapping[str, Any] | None = None, start_tick: int = 0
) -> Run:
    """What a sink holds; valid until the sink is used again.

    Tick 0 is ``start_tick`` base ticks after time 0.
    """
    stores = {group.name: MemoryStore(sink, n) for n, group in enumerate(sink.groups)}
    return Run(Path(), stores, sink.base_rate, manifest or {}, lambda: None, start_tick=start_tick)


def extremes_of(sink: MemorySink) -> dict[str, tuple[float, float]]:
    """The least and the greatest value of each signal; NaN where a row has no number."""
    found: dict[str, tuple[float, float]] = {}
    for number, group in enumerate(sink.groups):
        cells = sink.rows(number)
        if not len(cells):
            found |= {column.name: (math.nan, math.nan) for column in group.columns}
            continue
        # All columns at once, as what each may be: one that is whole numbers is no float.
        floats = cells.view(np.float64)
        lows, highs = floats.min(axis=0), floats.max(axis=0)
        least, most = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
        ends = zip(lows.tolist(), highs.tolist(), least, most, strict=True)
        for column, (low, high, first, last) in zip(group.columns, ends, strict=True):
            found[column.name] = (low, high) if column.is_float else (first, last)
    return found
