"""A smaller automaton that moves much like a large one: where to look for words that grow.

Balanced truncation (Moore 1981) of the mean map: what is both easily reached and seen for long is
kept. Nothing is proved with it; a word that it suggests counts with the maps themselves.
"""

from __future__ import annotations

import numpy as np

from cosim.theory.numerics import Real, spectral_radius
from cosim.theory.robust.automaton import Automaton

DOUBLINGS = 12


def reduced(automaton: Automaton, order: int) -> Automaton:
    """The automaton on the ``order`` directions that matter most; itself where it is no larger."""
    maps = automaton.maps
    if maps.shape[1] <= order:
        return automaton
    mean = maps.mean(axis=0)
    scale = 1.02 * max(spectral_radius(mean), 1e-6)
    reached, seen = _gramian(mean / scale), _gramian(mean.T / scale)
    into, back = np.linalg.cholesky(reached), np.linalg.cholesky(seen)
    left, values, right = np.linalg.svd(back.T @ into)
    share = 1.0 / np.sqrt(values[:order])
    lift = into @ right[:order].T * share
    lower = (back @ left[:, :order] * share).T
    return Automaton(lower @ maps @ lift, automaton.edges, automaton.nodes)


def _gramian(matrix: Real) -> Real:
    """Σ_k Mᵏ Mᵏᵀ by doubling, of trace n and never singular."""
    n = len(matrix)
    total, step = np.eye(n), matrix
    for _ in range(DOUBLINGS):
        total = total + step @ total @ step.T
        step = step @ step
    return total / (np.trace(total) / n) + 1e-12 * np.eye(n)
