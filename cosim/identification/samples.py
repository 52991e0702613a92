"""What the records of one device give: its geometry, and rows with torque, angle and force.

A row counts where its sample is new, or one or two ticks late, and the output was on, where no
joint was at its torque limit, and where the clock goes on by one tick; runs of such rows are
smoothed each for itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cosim.identification.five_bar import Array, FiveBar

OUTPUT_ENABLED, ACTIVE = 8, 2
"""Bits of a device's ``status``."""
BRIDGED = 2
"""Ticks without a new sample that are bridged; a device that moves on its own clock has them."""
AT_LIMIT = 0.995
"""Share of the torque limit from which on a joint counts as saturated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """One run: a row a tick (s). ``angle`` (rad), ``torque`` (N.m) and ``force`` (N): (rows, 2).

    ``payload`` (kg) is what was put on the tip, ``None`` where nobody said. ``force`` acts on the
    tip in the device's frame; ``None`` where no sensor was there. ``limit`` is the torque limit.
    """

    name: str
    digest: str
    date: str
    tick: float
    ticks: NDArray[np.int64]
    angle: Array
    torque: Array
    age: NDArray[np.int64]
    status: NDArray[np.int64]
    limit: float
    payload: float | None = None
    force: Array | None = None
    force_age: NDArray[np.int64] | None = None

    def usable(self) -> NDArray[np.bool_]:
        """Which rows count, shape (rows,)."""
        return self.fresh() & self.pushing() & ~self.saturated() & self.finite()

    def fresh(self) -> NDArray[np.bool_]:
        """Rows whose measurements are new."""
        fresh = self.age == 0
        return fresh if self.force_age is None else fresh & (self.force_age == 0)

    def bridged(self) -> Recording:
        """With what was measured where samples were late, on the line between their neighbours.

        Two clocks that are not one make a tick without a sample every now and then. What a line
        leaves out of the motion in three ticks is a small part of an encoder's count.
        """
        fresh = np.flatnonzero(self.fresh())
        late = np.diff(fresh) - 1
        ends = fresh[1:][(late > 0) & (late <= BRIDGED)]
        before = np.searchsorted(fresh, ends) - 1
        rows = np.array(
            [
                row
                for end, at in zip(ends, before, strict=True)
                for row in range(fresh[at] + 1, end)
            ],
            dtype=np.intp,
        )
        if not len(rows):
            return self

        def filled(values: Array) -> Array:
            new = values.copy()
            for column in range(values.shape[1]):
                new[rows, column] = np.interp(rows, fresh, values[fresh, column])
            return new

        age = self.age.copy()
        age[rows] = 0
        force_age = None if self.force_age is None else self.force_age.copy()
        if force_age is not None:
            force_age[rows] = 0
        return replace(
            self,
            angle=filled(self.angle),
            age=age,
            force=None if self.force is None else filled(self.force),
            force_age=force_age,
        )

    def pushing(self) -> NDArray[np.bool_]:
        """Rows in which torque was let out."""
        return (self.status & (OUTPUT_ENABLED | ACTIVE)) == (OUTPUT_ENABLED | ACTIVE)

    def saturated(self) -> NDArray[np.bool_]:
        """Rows in which a joint was at its limit."""
        if self.limit <= 0.0:
            return np.zeros(len(self.ticks), dtype=np.bool_)
        return np.any(np.abs(self.torque) >= AT_LIMIT * self.limit, axis=1)

    def finite(self) -> NDArray[np.bool_]:
        """Rows in which every value is a number."""
        known = np.all(np.isfinite(self.angle) & np.isfinite(self.torque), axis=1)
        if self.force is not None:
            known &= np.all(np.isfinite(self.force), axis=1)
        return known

    def stretches(self, shortest: int, step: int) -> Iterator[slice]:
        """Ranges of usable rows without a gap, a ``step`` of base ticks apart, long enough."""
        usable = self.usable()
        breaks = ~usable[1:] | ~usable[:-1] | (np.diff(self.ticks) != step)
        edges = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(usable)]
        for first, end in itertools.pairwise(edges):
            if end - first >= shortest and usable[first]:
                yield slice(first, end)


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """Rows of all runs, and why some do not count."""

    rows: int = 0
    used: int = 0
    saturated: int = 0
    stale: int = 0
    without_output: int = 0
    gaps: int = 0

    @classmethod
    def of(cls, recordings: list[Recording], used: int, steps: list[int]) -> Counts:
        """What the recordings hold; ``used`` rows had a part in the result."""
        return cls(
            rows=sum(len(each.ticks) for each in recordings),
            used=used,
            saturated=sum(int(np.sum(each.saturated() & each.pushing())) for each in recordings),
            stale=sum(int(np.sum(~each.fresh())) for each in recordings),
            without_output=sum(int(np.sum(~each.pushing())) for each in recordings),
            gaps=sum(
                int(np.sum(np.diff(each.ticks) != step))
                for each, step in zip(recordings, steps, strict=True)
            ),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Described:
    """What is said of a device elsewhere: geometry, preset, torque limit (N.m), declared latency.

    ``home`` (rad) is the pose whose inertia is told; ``None`` where the device has none.
    """

    bar: FiveBar
    preset: str
    limit: float
    latency_ticks: int = 0
    home: tuple[float, float] | None = None
