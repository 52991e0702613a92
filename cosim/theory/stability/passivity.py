"""Passivity and Z-width of a rendered coupler on a device with physical damping.

Colgate and Schenkel (1997, theorem 1): a virtual wall with transfer function H(z) from sampled
position to held force is passive with every passive operator exactly where

    b > T/2 · max_ω Re{(1 − e^{−jωT}) H(e^{jωT})} / (1 − cos ωT),   0 ≤ ω ≤ π/T.

The coupler is K + B (z − 1)/(T z), velocity by backward difference of the position, with z^{−d}.
"""

from __future__ import annotations

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.numerics import Real

_ANGLES: Real = np.linspace(1e-4, np.pi, 20001)


def _demands(period: float, delay: int) -> tuple[Real, Real]:
    """Physical damping that 1 N/m and 1 N·s/m demand at each angle ωT, shape (angles,) each."""
    backward = 1.0 - np.exp(-1j * _ANGLES)
    late = np.exp(-1j * delay * _ANGLES)
    scale = period / 2.0 / (1.0 - np.cos(_ANGLES))
    return scale * (backward * late).real, scale * (backward * backward * late).real / period


def damping_for_passivity(stiffness: float, damping: float, period: float, delay: int = 0) -> float:
    """The physical damping above which the rendered coupler is passive; K T/2 + B without delay.

    Args:
        stiffness: K, N/m.
        damping: B, N·s/m.
        period: T in s, of the loop that renders it (T_t where the network is in it).
        delay: d, in samples of T.

    Returns:
        N·s/m.
    """
    by_stiffness, by_damping = _demands(period, delay)
    return float(np.max(stiffness * by_stiffness + damping * by_damping))


def passive_stiffness(
    device_damping: float, damping: float, period: float, delay: int = 0
) -> float | None:
    """The largest K that is passive at a coupler damping B: one point of the Z-width.

    Args:
        device_damping: physical damping of the device, N·s/m.
        damping: B, N·s/m.
        period: T in s.
        delay: d, in samples of T.

    Returns:
        N/m, or None where B alone is already too much for the device.

    Raises:
        InputError: where the physical damping is negative.
    """
    if device_damping < 0:
        raise InputError(
            f"The device's physical damping is {device_damping:g} N·s/m: it cannot be negative."
        )
    by_stiffness, by_damping = _demands(period, delay)
    left = device_damping - damping * by_damping
    # K a ≤ left at every angle: an upper bound where a > 0, a lower one where a < 0.
    rising, falling = by_stiffness > 1e-15, by_stiffness < -1e-15
    highest = float(np.min(left[rising] / by_stiffness[rising]))
    lowest = float(np.max(left[falling] / by_stiffness[falling], initial=0.0))
    return highest if highest >= lowest else None
