"""The one door to clarabel: the largest margin of linear matrix inequalities.

    max t   with   C_b + Σ_k x_k E_bk ⪰ t I   in every block b,   c · x = d.

Clarabel (Goulart and Chen 2024) is an interior-point solver, installed by the extra ``robust``.
Nothing that it returns is believed: whoever asks verifies x.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.numerics import Real


@dataclass(frozen=True, slots=True)
class Block:
    """One matrix inequality.

    Attributes:
        effect: E, shape (unknowns, n, n), symmetric.
        constant: C, shape (n, n), or None for zero.
    """

    effect: Real
    constant: Real | None = None


def symmetric_basis(n: int) -> Real:
    """The symmetric matrices of order n by their upper triangle, shape (n (n + 1)/2, n, n)."""
    rows, columns = np.triu_indices(n)
    basis = np.zeros((rows.size, n, n))
    places = np.arange(rows.size)
    basis[places, rows, columns] = 1.0
    basis[places, columns, rows] = 1.0
    return basis


def maximise_margin(blocks: list[Block], sum_of: Real, total: float) -> Real:
    """The unknowns x with the largest margin t.

    Args:
        blocks: the inequalities.
        sum_of: c, shape (unknowns,).
        total: d.

    Returns:
        x, shape (unknowns,), the best that was found.

    Raises:
        InputError: clarabel is not installed.
    """
    clarabel = _clarabel()
    sparse: Any = import_module("scipy.sparse")
    unknowns = sum_of.size
    rows: list[Any] = [np.append(sum_of, 0.0)[None, :]]
    right = [np.array([total])]
    cones: list[Any] = [clarabel.ZeroConeT(1)]
    for block in blocks:
        n = block.effect.shape[1]
        down, across, scale = _triangle(n)
        identity = np.where(down == across, 1.0, 0.0)[:, None]
        rows.append(np.hstack([-(block.effect[:, down, across] * scale).T, identity]))
        constant = np.zeros((n, n)) if block.constant is None else block.constant
        right.append(constant[down, across] * scale)
        cones.append(clarabel.PSDTriangleConeT(n))
    settings: Any = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = 100
    cost = np.zeros(unknowns + 1)
    cost[-1] = -1.0
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((unknowns + 1, unknowns + 1)),
        cost,
        sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(right),
        cones,
        settings,
    )
    return np.asarray(solver.solve().x, dtype=np.float64)[:unknowns]


@cache
def _triangle(n: int) -> tuple[Any, Any, Real]:
    """Rows and columns of the upper triangle, column after column, off-diagonals times √2."""
    down, across = np.tril_indices(n)
    rows, columns = across, down
    return rows, columns, np.where(rows == columns, 1.0, np.sqrt(2.0))


def _clarabel() -> Any:
    try:
        return import_module("clarabel")
    except ImportError:
        raise InputError(
            "This bound needs the solver clarabel, which is not installed: "
            "pip install 'cohaptic[robust]'."
        ) from None
