"""Steady drift of a loop under a constant force: what the DC damping (6.2) is read from."""

from __future__ import annotations

import numpy as np

from cosim.theory.numerics import Real, solve


def steady_drift(
    frame_map: Real, force: Real, translation: Real, period: float
) -> tuple[float, Real]:
    """The drift at 1 m/s: s(k) = k T t + s₀, solving (M − I) s₀ + b f = T t.

    Posed at a given speed and solved for the force, it has an answer even where no force is needed.

    Args:
        frame_map: M, shape (n, n), with M t = t.
        force: b, the effect on s of 1 N held over the period, shape (n,).
        translation: t, shape (n,).
        period: T in s.

    Returns:
        The force in N, and s₀, shape (n,), whose first translated coordinate is 0.
    """
    n = translation.size
    pivot = int(np.argmax(translation != 0.0))
    system = frame_map - np.eye(n)
    system[:, pivot] = force
    solution = solve(system, period * translation)
    needed = float(solution[pivot])
    solution[pivot] = 0.0
    return needed, solution


def steady_state(frame_map: Real, force: Real) -> Real:
    """The fixed point under a constant force of 1 N, s₀ = (I − M)⁻¹ b, where something holds it."""
    return solve(np.eye(force.size) - frame_map, force)
