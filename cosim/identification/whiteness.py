"""Whether anything is left in the residual that hangs together over time.

The kernel itself ties rows together that lie within some of its widths. Beyond that the residual of
a model that has everything is chance, so its correlations there are small and independent: their
squares, in units of what chance gives them (Bartlett 1946), add up to chi-square.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from cosim.identification.equations import Stretch
from cosim.identification.five_bar import Array

NEAR = 7.0
"""Widths of the kernel after which it ties rows by less than 1 %."""
LAGS = 6
"""Lags that are looked at, as far apart."""
LEVEL = 0.001
"""Below this chance the residual is called not white."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Whiteness:
    """``correlations`` (joints, lags) at ``lags`` (s), ``chance`` of more by chance, each joint."""

    lags: Array
    correlations: Array
    bound: Array
    chance: tuple[float, float]

    @property
    def is_white(self) -> bool:
        """Whether chance explains the residual of both joints."""
        return min(self.chance) >= LEVEL


def whiteness(found: list[Stretch], residual: Array) -> Whiteness:
    """The residual's correlations (rows, 2) beyond the kernel's reach."""
    stats: Any = import_module("scipy.stats")
    stride = max(1, round(found[0].kernel.width / found[0].kernel.tick))
    near = round(NEAR * found[0].kernel.width / found[0].kernel.tick / stride)
    lags = near * np.arange(1, LAGS + 1)
    grids = _grids(found, residual, stride)
    correlations, counts = _correlations(grids, np.concatenate([np.arange(1, near), lags]))
    tied = 1.0 + 2.0 * np.sum(correlations[:, : near - 1] ** 2, axis=1)
    far, pairs = correlations[:, near - 1 :], counts[near - 1 :]
    deviation = np.sqrt(tied[:, None] / pairs[None, :])
    totals = np.sum((far / deviation) ** 2, axis=1)
    chances = [float(stats.chi2.sf(total, LAGS)) for total in totals]
    return Whiteness(
        lags=lags * stride * found[0].kernel.tick,
        correlations=far,
        bound=1.96 * deviation,
        chance=(chances[0], chances[1]),
    )


def _grids(found: list[Stretch], residual: Array, stride: int) -> list[Array]:
    """Residuals on an even grid a stretch, NaN where no row is."""
    grids: list[Array] = []
    first = 0
    for each in found:
        cells = each.chosen // stride
        grid = np.full((int(cells[-1]) + 1, 2), np.nan)
        grid[cells] = residual[first : first + len(cells)]
        grids.append(grid)
        first += len(cells)
    return grids


def _correlations(grids: list[Array], lags: Array) -> tuple[Array, Array]:
    """Correlations (joints, lags) over all pairs that are there, and how many there are."""
    power = np.nanmean(np.concatenate(grids) ** 2, axis=0)
    sums, counts = np.zeros((2, len(lags))), np.zeros(len(lags))
    for at, lag in enumerate(lags.astype(int)):
        for grid in grids:
            products = grid[lag:] * grid[:-lag]
            there = np.isfinite(products[:, 0])
            sums[:, at] += products[there].sum(axis=0)
            counts[at] += int(there.sum())
    counts = np.maximum(counts, 1)
    return sums / counts / power[:, None], counts
