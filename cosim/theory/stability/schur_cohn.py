"""The Schur–Cohn test on whole arrays of polynomials: are all roots inside the unit circle."""

from __future__ import annotations

import numpy as np

from cosim.theory.numerics import Bool, Real


def all_roots_inside(coefficients: Real) -> Bool:
    """Whether every root has magnitude below 1, by the step-down recursion.

    p stays stable exactly where |p_n / p_0| < 1 and (p − (p_n/p_0) p*)/z is stable.

    Args:
        coefficients: shape (degree + 1, ...), highest power first, the first never zero.

    Returns:
        Shape (...).
    """
    inside = np.ones(coefficients.shape[1:], dtype=np.bool_)
    polynomial = coefficients
    while polynomial.shape[0] > 1:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            reflection = polynomial[-1] / polynomial[0]
            # NaN compares false: a polynomial that was already refused may overflow.
            inside &= np.abs(reflection) < 1.0
            polynomial = polynomial[:-1] - reflection * polynomial[:0:-1]
    return inside


def divide_by_z_minus_one(coefficients: Real) -> Real:
    """Divide out a root at z = 1 (synthetic division; the remainder is dropped).

    Args:
        coefficients: shape (degree + 1, ...), highest power first.

    Returns:
        Shape (degree, ...).
    """
    return np.cumsum(coefficients[:-1], axis=0)


def multiply(one: Real, other: Real) -> Real:
    """The product of two arrays of polynomials, shapes (m, ...) and (n, ...)."""
    product = np.zeros((one.shape[0] + other.shape[0] - 1, *np.broadcast(one[0], other[0]).shape))
    for power, coefficient in enumerate(other):
        product[power : power + one.shape[0]] += one * coefficient
    return product
