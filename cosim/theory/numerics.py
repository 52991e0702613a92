"""Typed doors to NumPy and SciPy: the few numerical routines that the theory calls."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Bool = NDArray[np.bool_]


def matrix_exponential(matrix: Real) -> Real:
    """The exponential of a square matrix, shape (n, n)."""
    expm: Any = import_module("scipy.linalg").expm
    return np.asarray(expm(matrix), dtype=np.float64)


def eigenvalues(matrix: Real) -> Complex:
    """All eigenvalues of a square matrix (or of a stack of them, the last two axes square)."""
    return np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)


def solve(matrix: Real, right: Real) -> Real:
    """The solution of a square system, shapes (n, n) and (n,) or (n, m)."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)


def solve_complex(matrix: Complex, right: Real | Complex) -> Complex:
    """The solution of a complex square system, shapes (n, n) and (n,)."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.complex128)


def spectral_radius(matrix: Real) -> float:
    """The largest eigenvalue magnitude of a square matrix; 0 for an empty one."""
    if matrix.shape[0] == 0:
        return 0.0
    return float(np.max(np.abs(eigenvalues(matrix))))


def find_root(function: Callable[[float], float], low: float, high: float) -> float:
    """The zero of ``function`` in [low, high], whose ends have opposite signs (Brent)."""
    brentq: Any = import_module("scipy.optimize").brentq
    return float(brentq(function, low, high, xtol=1e-13, rtol=4e-15, maxiter=200))


def minimise_bounded(
    function: Callable[[float], float], low: float, high: float
) -> tuple[float, float]:
    """A local minimum of ``function`` in [low, high]: where it is, and its value."""
    minimise: Any = import_module("scipy.optimize").minimize_scalar
    result: Any = minimise(
        function, bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)}
    )
    return float(result.x), float(result.fun)


def largest_eigenvalue_of_map(apply: Callable[[Real], Real], start: Real) -> float:
    """The largest eigenvalue magnitude of a linear map given as a function (Arnoldi).

    Args:
        apply: the map, from a vector of shape (size,) to a vector of shape (size,).
        start: where to start, shape (size,), with a part in the wanted direction.
    """
    linalg: Any = import_module("scipy.sparse.linalg")
    operator = linalg.LinearOperator((start.size, start.size), matvec=apply, dtype=np.float64)
    try:
        values: Any = linalg.eigs(
            operator, k=1, ncv=40, which="LM", v0=start, return_eigenvectors=False, tol=1e-9
        )
    except linalg.ArpackNoConvergence:
        # Crowded spectra: fall back on the whole matrix.
        return spectral_radius(np.array([apply(column) for column in np.eye(start.size)]).T)
    return float(np.max(np.abs(cast("Complex", values))))


def gamma_distribution(value: float, *, mean: float, deviation: float) -> float:
    """The probability that a gamma-distributed quantity is at most ``value``."""
    special: Any = import_module("scipy.special")
    shape = (mean / deviation) ** 2
    return float(special.gammainc(shape, max(0.0, value) * shape / mean))
