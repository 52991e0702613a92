"""A run that was kept in memory, read as one from a file is."""

from __future__ import annotations

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


def largest_sizes(sink: MemorySink) -> dict[str, float]:
    """The largest size that each signal had; 0 of whole numbers, which do not run away."""
    found: dict[str, float] = {}
    for number, group in enumerate(sink.groups):
        cells = sink.rows(number)
        sizes = np.abs(cells.view(np.float64))
        largest = np.maximum.reduce(sizes, axis=0, initial=0.0)
        if np.isnan(largest).any():  # the slower way looks past what is no number
            largest = np.fmax.reduce(sizes, axis=0, initial=0.0)
        for column, size in zip(group.columns, largest.tolist(), strict=True):
            found[column.name] = size if column.is_float else 0.0
    return found
