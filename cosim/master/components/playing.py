"""Rows over time as the kernel shows them: contiguous, their times in base ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Played
from cosim.master.assembly.clock import Clock
from cosim.master.kernel.structures import PlayedStruct

SLACK = 0.01
"""How far beside a step a row counts from it all the same (steps): times in files are rounded."""


@dataclass(frozen=True, slots=True)
class PlayedRows:
    """The structure, and the memory that it points to."""

    struct: PlayedStruct
    times: NDArray[np.float64]
    rows: NDArray[np.float64]


def rows_to_play(played: Played, columns: Sequence[int], clock: Clock, period: int) -> PlayedRows:
    """Some columns of what is played by a component that steps every ``period`` ticks."""
    steps = (played.times * float(clock.base_rate) - clock.start_tick) / period
    near = np.rint(steps)
    times = np.where(np.abs(steps - near) <= SLACK, near, steps) * period
    rows = np.ascontiguousarray(played.rows[:, columns])
    struct = PlayedStruct(
        times.ctypes.data, rows.ctypes.data, len(times), len(columns), played.is_linear, 0
    )
    return PlayedRows(struct, times, rows)
