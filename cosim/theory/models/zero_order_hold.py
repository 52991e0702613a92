"""Exact zero-order-hold discretisation (3.13)–(3.17)."""

from __future__ import annotations

import numpy as np

from cosim.theory.numerics import Real, matrix_exponential


def zero_order_hold(A: Real, B: Real, period: float) -> tuple[Real, Real]:
    """Discretise ẋ = A x + B u with u held over the period (3.15).

    Args:
        A: shape (n, n).
        B: shape (n, m).
        period: s.

    Returns:
        e^{AT}, shape (n, n), and ∫₀ᵀ e^{Aη} dη B, shape (n, m).
    """
    n, m = B.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n] = A
    block[:n, n:] = B
    exponential = matrix_exponential(block * period)
    return exponential[:n, :n], exponential[:n, n:]


def mass_under_held_force(
    mass: Real | float, damping: Real | float, period: float, stiffness: float = 0.0
) -> tuple[Real, Real]:
    """A mass with viscous damping under a held force, in closed form where no spring holds it.

    Args:
        mass: kg, a number or an array of any shape.
        damping: N·s/m, of the same shape or a number.
        period: s.
        stiffness: N/m, of a spring to the ground.

    Returns:
        The state matrix, shape (..., 2, 2), and the input vector, shape (..., 2), for the state
        (position, velocity) and a force in N.
    """
    mass_array, damping_array = np.broadcast_arrays(
        np.asarray(mass, dtype=np.float64), np.asarray(damping, dtype=np.float64)
    )
    A = np.zeros((*mass_array.shape, 2, 2))
    B = np.zeros((*mass_array.shape, 2))
    if stiffness:
        for place in np.ndindex(mass_array.shape):
            inverse, b = 1.0 / float(mass_array[place]), float(damping_array[place])
            motion = np.array([[0.0, 1.0], [-stiffness * inverse, -b * inverse]])
            A[place], column = zero_order_hold(motion, np.array([[0.0], [inverse]]), period)
            B[place] = column[:, 0]
        return A, B
    A[..., 0, 0] = 1.0
    if not np.any(damping_array):
        A[..., 0, 1], A[..., 1, 1] = period, 1.0
        B[..., 0], B[..., 1] = period * period / mass_array / 2.0, period / mass_array
        return A, B
    rate = damping_array * (period / mass_array)
    damped = rate != 0.0
    safe = np.where(damped, rate, 1.0)
    # φ1 = (1 − e^{−r})/r and φ2 = (1 − φ1)/r; the series where r is too small to subtract.
    first = np.where(damped, -np.expm1(-safe) / safe, 1.0)
    series = 0.5 - rate / 6.0 + rate**2 / 24.0 - rate**3 / 120.0
    second = np.where(np.abs(rate) < 1e-3, series, (1.0 - first) / safe)
    A[..., 0, 1] = period * first
    A[..., 1, 1] = np.exp(-rate)
    B[..., 0] = period * period / mass_array * second
    B[..., 1] = period / mass_array * first
    return A, B
