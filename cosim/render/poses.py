"""Where everything of a scene is, at the moments of the frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.record.reader import Run
from cosim.record.scene import recorded_of

Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Poses:
    """Values of the signals that a scene names, held at each frame.

    Attributes:
        times: the frames' moments (s), shape (frames,).
        values: by the signal's name, shape (frames,); NaN where nothing was recorded yet.
    """

    times: Numbers
    values: Mapping[str, Numbers]

    def __len__(self) -> int:
        return int(self.times.size)

    def pair(self, names: Sequence[str] | None) -> Numbers | None:
        """Two signals beside each other, shape (frames, 2); ``None`` where one is missing."""
        if not names or any(name not in self.values for name in names[:2]):
            return None
        return np.stack([self.values[name] for name in names[:2]], axis=1)

    def one(self, name: str | None) -> Numbers | None:
        """One signal, shape (frames,)."""
        return None if name is None else self.values.get(name)


def read_poses(run: Run, scene: Mapping[str, Any], ticks: Sequence[int]) -> Poses:
    """The scene's signals at some base ticks, each value held until the next."""
    values: dict[str, Numbers] = {}
    moments = np.asarray(ticks, np.int64)
    for name in recorded_of(scene, run):
        signal = run[name]
        rows = np.minimum(moments // signal.group.period, signal.group.rows - 1)
        first, last = int(rows[0]), int(rows[-1])
        values[name] = signal[first : last + 1].astype(np.float64)[rows - first]
    return Poses(run.seconds(moments), values)


def frame_ticks(run: Run, start: Fraction, until: Fraction, step: Fraction) -> list[int]:
    """The tick at or before each frame, ``step`` seconds apart; times count from 0."""
    count = int((until - start) / step) + 1
    moments = ((start + number * step) * run.base_rate for number in range(count))
    return [min(run.ticks - 1, int(moment) - run.start_tick) for moment in moments]
