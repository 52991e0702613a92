"""The map of second moments, and a proof in few periods that they decay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.chain import Chain
from cosim.theory.chance.decay import surely_decays

Real = NDArray[np.float64]

NEGLIGIBLE = 1e-14
"""Singular values below, of the largest one, are rounding."""


@dataclass(frozen=True, slots=True)
class _Move:
    """From mode to mode: the mean of the maps between them, and what varies around it.

    Σ p M X Mᵀ = p̄ M̄ X M̄ᵀ + Σ p D X Dᵀ, and the D of the fates of few packets are of low rank:
    D = U Vᵀ with one V.
    """

    source: int
    target: int
    mean: Real
    varying: Real
    """√p U side by side, shape (n, outcomes · rank)."""
    read: Real
    """V, shape (n, rank)."""


class SecondMoments:
    """X_j ← Σ p(i, e → j) M_e X_i M_eᵀ.

    Args:
        maps: shape (outcomes, n, n).
        chain: what chooses between them.
        numbers: the map of each of the chain's steps.
    """

    def __init__(self, maps: Real, chain: Chain, numbers: Sequence[int]) -> None:
        self._modes, self._size = chain.modes, maps.shape[1]
        between: dict[tuple[int, int], list[tuple[float, Real]]] = {}
        for step, number in zip(chain.steps, numbers, strict=True):
            pair = between.setdefault((step.source, step.target), [])
            pair.append((step.probability, maps[number]))
        self._moves = [_move(*pair, which) for pair, which in between.items()]

    @property
    def identity(self) -> Real:
        """The unit matrix in every mode, flat."""
        return np.tile(np.eye(self._size).reshape(-1), self._modes)

    def apply(self, vector: Real) -> Real:
        """One period further, flat."""
        moments = np.asarray(vector).reshape(self._modes, self._size, self._size)
        return self._moved(moments).reshape(-1)

    def _moved(self, moments: Real) -> Real:
        moved = np.zeros_like(moments)
        for move in self._moves:
            now = moments[move.source]
            moved[move.target] += move.mean @ now @ move.mean.T
            rank = move.read.shape[1]
            if rank:
                inner = move.read.T @ now @ move.read
                parts = move.varying.reshape(self._size, -1, rank) @ inner
                moved[move.target] += parts.reshape(self._size, -1) @ move.varying.T
        return moved

    def surely_decay(self) -> bool:
        """Whether few periods show that the radius is below 1; if not, it may be all the same."""
        return surely_decays(self._moved, self._modes, self._size)


def _move(source: int, target: int, which: Sequence[tuple[float, Real]]) -> _Move:
    chances = np.array([chance for chance, _ in which])
    maps = np.array([one for _, one in which])
    whole = float(chances.sum())
    mean = np.tensordot(chances / whole, maps, 1)
    apart = maps - mean
    size = mean.shape[0]
    _, values, rows = np.linalg.svd(apart.reshape(-1, size), full_matrices=False)
    rank = int((values > NEGLIGIBLE * max(float(np.abs(maps).max()), 1.0)).sum())
    read = rows[:rank].T
    varying = (apart @ read) * np.sqrt(chances)[:, None, None]
    return _Move(
        source,
        target,
        np.sqrt(whole) * mean,
        np.ascontiguousarray(varying.transpose(1, 0, 2)).reshape(size, -1),
        read,
    )
