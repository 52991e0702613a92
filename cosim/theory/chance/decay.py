"""A proof in few periods that second moments decay."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cosim.theory.numerics import Real

DECAYED = 0.5
"""The unit matrix has decayed where it is below so much of itself: by more than rounding."""
LOOKED_AT, PATIENCE, GIVEN_UP = 20, 140, 1500
"""Periods between two looks at it, in which nothing is concluded, and at most."""


def surely_decays(apply: Callable[[Real], Real], modes: int, size: int) -> bool:
    """Whether some periods take the unit matrix below itself, so that ρ is below 1.

    A map of second moments is positive, as each of its powers is, and the norm of such a map is
    what it makes of the unit matrix (Russo and Dye 1966).

    Args:
        apply: one period, from and to shape (modes, size, size).
        modes: of the chain.
        size: of the state.

    Returns:
        False where so many periods do not show it: the moments may decay all the same.
    """
    now, before = np.tile(np.eye(size), (modes, 1, 1)), np.inf
    for period in range(1, GIVEN_UP + 1):
        now = apply(now)
        if period % LOOKED_AT == 0:
            symmetric = 0.5 * (now + now.transpose(0, 2, 1))
            if not np.isfinite(symmetric).all():
                return False
            norm = float(np.linalg.eigvalsh(symmetric).max())
            if norm < DECAYED:
                return True
            # Where it would not come so far at the rate of late, the rest is not waited for.
            looks = (GIVEN_UP - period) // LOOKED_AT
            if norm * (norm / before) ** looks > DECAYED and period > PATIENCE:
                return False
            before = norm
    return False
