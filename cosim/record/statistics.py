"""Statistics and the min/max envelope of every recorded column, accumulated block by block.

Memory depends on the number of columns alone, never on the length of the run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

ENVELOPE_BINS = 1024
NAN = float("nan")


@dataclass(frozen=True, slots=True)
class Statistics:
    """One column's numbers over all rows that hold one; NaN throughout where none does.

    ``rms`` is √(mean of squares), ``std`` the deviation from the mean over all rows (not n - 1),
    ``changes`` how many rows differ, bit for bit, from the row before, ``missing`` the NaN rows.
    """

    rows: int
    missing: int
    minimum: float
    maximum: float
    mean: float
    rms: float
    std: float
    changes: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON: NaN as ``None``."""
        return {
            key: None if isinstance(value, float) and not np.isfinite(value) else value
            for key, value in ((name, getattr(self, name)) for name in self.__slots__)
        }


@dataclass(frozen=True, slots=True)
class ColumnSummary:
    """One column's statistics and its envelope.

    ``lows`` and ``highs`` hold the extremes of each bin of ``rows_per_bin`` rows, shape (bins,).
    """

    statistics: Statistics
    lows: NDArray[np.float64]
    highs: NDArray[np.float64]
    rows_per_bin: int


class Moments:
    """How many numbers columns have, their means and squared deviations, over blocks of rows.

    Blocks are merged with the update of Chan, Golub and LeVeque (1979), which does not cancel as
    the sum of squares does. ``counts``, ``means`` and ``deviations`` (sums of squares) have shape
    (columns,).
    """

    def __init__(self, columns: int) -> None:
        self.counts = np.zeros(columns)
        self.means = np.zeros(columns)
        self.deviations = np.zeros(columns)
        self._is_empty = True

    def update(self, values: NDArray[np.float64], work: NDArray[np.float64] | None = None) -> None:
        """Take the next rows, of shape (columns, rows); ``work`` is room of the same shape.

        A column with NaN in this block counts only its other rows.
        """
        here = np.full(values.shape[0], float(values.shape[1]))
        with np.errstate(invalid="ignore", over="ignore"):
            total = values.sum(axis=1)
            holes: dict[int, NDArray[np.bool_]] = {}
            if np.isnan(total).any():
                holes = {int(row): np.isnan(values[row]) for row in np.flatnonzero(np.isnan(total))}
            for row, missing in holes.items():
                here[row] -= np.count_nonzero(missing)
                total[row] = values[row].sum(where=~missing)
            mean = _ratio(total, here) if holes else total / here
            apart = np.subtract(values, mean[:, None], out=work)
            for row, missing in holes.items():
                apart[row, missing] = 0.0
            squares = np.einsum("ij,ij->i", apart, apart)
            if self._is_empty:
                self._is_empty = False
                self.counts, self.means, self.deviations = here, mean, squares
                return
            both = self.counts + here
            share = _ratio(here, both)
            step = mean - self.means
            self.means += step * share
            self.deviations += squares + step**2 * self.counts * share
            self.counts = both

    def of(self, column: int) -> tuple[int, float, float, float]:
        """Of one column the count, the mean, the rms and the deviation from the mean."""
        count = int(self.counts[column])
        if count == 0:
            return 0, NAN, NAN, NAN
        mean = float(self.means[column])
        variance = float(self.deviations[column]) / count
        return count, mean, float(np.hypot(mean, np.sqrt(variance))), float(np.sqrt(variance))


def _ratio(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """The quotients, 0 where nothing is divided by nothing."""
    return np.divide(one, other, out=np.zeros_like(one), where=other > 0)


class ColumnStatistics:
    """Accumulates a group's columns over blocks of rows."""

    def __init__(
        self, is_float: NDArray[np.bool_], capacity: int, bins: int = ENVELOPE_BINS
    ) -> None:
        """``is_float`` has shape (columns,); ``capacity`` rows are spread over at most ``bins``."""
        columns = is_float.size
        # Inside, floats come first and integers after them, so that each kind converts in one go.
        self._order = np.argsort(~is_float, kind="stable")
        self._floats = int(np.count_nonzero(is_float))
        self._place = np.argsort(self._order)
        self.rows_per_bin = max(1, -(-capacity // bins))
        bins = max(1, -(-capacity // self.rows_per_bin))
        self._lows = np.full((columns, bins), np.nan)
        self._highs = np.full((columns, bins), np.nan)
        self.rows = 0
        self._moments = Moments(columns)
        self._changes = np.zeros(columns, np.int64)
        self._last = np.zeros(columns, np.int64)
        # Kept from block to block: fresh memory of this size costs more than the arithmetic.
        self._values: NDArray[np.float64] = np.zeros((columns, 0))
        self._work: NDArray[np.float64] = np.zeros((columns, 0))

    def update(self, cells: NDArray[np.int64]) -> None:
        """Take the next rows; ``cells`` has shape (columns, rows), floats as their bit pattern."""
        rows = cells.shape[1]
        if rows == 0:
            return
        self._count_changes(cells)
        if rows > self._values.shape[1]:
            self._values = np.empty(cells.shape)
            self._work = np.empty(cells.shape)
        values = self._values[:, :rows]
        for row, column in enumerate(self._order):
            values[row] = cells[column].view(np.float64) if row < self._floats else cells[column]
        self._widen_envelope(values)
        self._moments.update(values, self._work[:, :rows])
        self.rows += rows

    def summary(self, column: int) -> ColumnSummary:
        """The statistics and the envelope of one column so far."""
        bins = -(-self.rows // self.rows_per_bin)
        place = self._place[column]
        return ColumnSummary(
            self[column], self._lows[place, :bins], self._highs[place, :bins], self.rows_per_bin
        )

    def __getitem__(self, column: int) -> Statistics:
        """The statistics of one column so far."""
        place = self._place[column]
        count, mean, rms, std = self._moments.of(int(place))
        changes = int(self._changes[column])
        if count == 0:
            return Statistics(self.rows, self.rows, NAN, NAN, NAN, NAN, NAN, changes)
        return Statistics(
            rows=self.rows,
            missing=self.rows - count,
            minimum=float(np.fmin.reduce(self._lows[place])),
            maximum=float(np.fmax.reduce(self._highs[place])),
            mean=mean,
            rms=rms,
            std=std,
            changes=changes,
        )

    def _count_changes(self, cells: NDArray[np.int64]) -> None:
        self._changes += np.count_nonzero(cells[:, 1:] != cells[:, :-1], axis=1)
        if self.rows:
            self._changes += cells[:, 0] != self._last
        self._last[:] = cells[:, -1]

    def _widen_envelope(self, values: NDArray[np.float64]) -> None:
        first, last = self.rows, self.rows + values.shape[1] - 1
        bins = slice(first // self.rows_per_bin, last // self.rows_per_bin + 1)
        starts = np.arange(bins.start, bins.stop, dtype=np.intp) * self.rows_per_bin - first
        starts[0] = 0
        for envelope, extreme in ((self._lows, np.fmin), (self._highs, np.fmax)):
            block = extreme.reduceat(values, starts, axis=1)
            extreme(envelope[:, bins], block, out=envelope[:, bins])
