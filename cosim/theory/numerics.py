"""Typed doors to NumPy and SciPy: the few numerical routines that the theory calls."""

from __future__ import annotations

import math
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


def find_root(
    function: Callable[[float], float], low: float, high: float, accuracy: float = 1e-13
) -> float:
    """The zero of ``function`` in [low, high], to ``accuracy`` and a few units in the last place.

    Brent's method (Algorithms for Minimization without Derivatives, 1973, chapter 4). Written out,
    because importing SciPy's takes longer than a whole design.

    Raises:
        ValueError: the function has the same sign at both ends.
    """
    before, now = low, high
    f_before, f_now = function(before), function(now)
    if f_before == 0.0:
        return before
    if f_now != 0.0 and (f_before > 0.0) == (f_now > 0.0):
        raise ValueError(f"no change of sign between {low:g} and {high:g}")
    # [now, other] brackets the zero and ``now`` is its better end.
    other, f_other = before, f_before
    step = last_step = now - before
    for _ in range(200):
        if abs(f_other) < abs(f_now):
            before, now, other = now, other, now
            f_before, f_now, f_other = f_now, f_other, f_now
        tolerance = _ROUNDING * abs(now) + 0.5 * accuracy
        half = 0.5 * (other - now)
        if abs(half) <= tolerance or f_now == 0.0:
            return now
        proposed = _interpolation((before, f_before), (now, f_now), (other, f_other))
        towards = proposed / half if abs(f_before) > abs(f_now) else -1.0
        # Taken where it stays inside three quarters of the bracket and steps keep halving.
        if (
            0.0 < towards < 1.5
            and tolerance <= abs(last_step)
            and 2 * abs(proposed) < abs(last_step)
        ):
            last_step, step = step, proposed
        else:
            last_step = step = half
        before, f_before = now, f_now
        now += step if abs(step) > tolerance else math.copysign(tolerance, half)
        f_now = function(now)
        if (f_now > 0.0) == (f_other > 0.0):
            other, f_other = before, f_before
            last_step = step = now - before
    return now


_ROUNDING = 4 * float(np.finfo(np.float64).eps)


def _interpolation(
    before: tuple[float, float], now: tuple[float, float], other: tuple[float, float]
) -> float:
    """The step from ``now`` to the zero of the inverse parabola (or the secant) through them."""
    (a, fa), (b, fb), (c, fc) = before, now, other
    if fa == fb:
        return math.inf
    if a == c or fc in (fa, fb):
        return -fb * (b - a) / (fb - fa)
    s, q, r = fb / fa, fa / fc, fb / fc
    return s * ((c - b) * q * (q - r) - (b - a) * (r - 1)) / -((q - 1) * (r - 1) * (s - 1))


def minimise_bounded(
    function: Callable[[float], float], low: float, high: float
) -> tuple[float, float]:
    """A local minimum of ``function`` in [low, high]: where it is, and its value."""
    minimise: Any = import_module("scipy.optimize").minimize_scalar
    result: Any = minimise(
        function, bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)}
    )
    return float(result.x), float(result.fun)


def largest_eigenvalue_of_map(
    apply: Callable[[Real], Real], start: Real, accuracy: float = 1e-9
) -> float:
    """The largest eigenvalue magnitude of a linear map given as a function (Arnoldi).

    Args:
        apply: the map, from a vector of shape (size,) to a vector of shape (size,).
        start: where to start, shape (size,), with a part in the wanted direction.
        accuracy: relative.
    """
    linalg: Any = import_module("scipy.sparse.linalg")
    # A slow swing's |λ|² and λ² are nearly alike in size: the largest of three.
    operator = linalg.LinearOperator((start.size, start.size), matvec=apply, dtype=np.float64)
    try:
        values: Any = linalg.eigs(
            operator, k=3, ncv=40, which="LM", v0=start, return_eigenvectors=False, tol=accuracy
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
