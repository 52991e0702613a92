"""The scene of a record, 32 times a second of model time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.foxglove.entities import RATE, SceneUpdates
from cosim.record.reader import Run
from cosim.record.scene import read_scene, recorded_of


def scene_updates(
    run: Run, names: set[str], first: int, last: int
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Base ticks ``first`` <= tick < ``last``, ``RATE`` a second, and the message of each.

    Only what ``names`` has the signals of is in it; nothing where the folder holds no scene.
    """
    scene = read_scene(run.folder)
    if scene is None or not names & {*recorded_of(scene, run)}:
        return
    step = max(1, round(run.base_rate / RATE))
    ticks = np.arange(first, last, step, dtype=np.int64)
    held = {name: _held(run, name, ticks) for name in recorded_of(scene, run) if name in names}
    updates = SceneUpdates(scene)
    for number, tick in enumerate(ticks.tolist()):
        at = {name: float(values[number]) for name, values in held.items()}
        if message := updates.message(at, nanoseconds(run, tick)):
            yield tick, message


def nanoseconds(run: Run, tick: int) -> int:
    """Model time of a base tick."""
    rate = run.base_rate
    return (tick + run.start_tick) * rate.denominator * 1_000_000_000 // rate.numerator


def _held(run: Run, name: str, ticks: NDArray[np.int64]) -> NDArray[np.float64]:
    signal = run[name]
    rows = np.minimum(ticks // signal.group.period, signal.group.rows - 1)
    return signal[int(rows[0]) : int(rows[-1]) + 1].astype(np.float64)[rows - rows[0]]
