"""Indices of transparency: what is felt between the extremes, and how alike both ends are.

Lawrence 1993: with Z_e at the far port a user feels Z_t = h₁₁ − h₁₂ h₂₁ Z_e / (1 + h₂₂ Z_e),
between Z_min = h₁₁ (the far hand is free) and Z_max = h₁₁ − h₁₂ h₂₁ / h₂₂ (it is held).

Yokokohji and Yoshikawa 1994: with the operator's impedance at the near port and Z_e at the far one,

    J_p = ∫₀^{ω_m} |G_xm − G_xs| / |1 + jωT| dω,   J_f = ∫₀^{ω_m} |G_fm − G_fs| / |1 + jωT| dω,

G from the operator's own force to the positions of both hands (m/N) and to the forces on them; both
are 0 where the two hands are one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.numerics import Complex, Real
from cosim.theory.robust.two_port import TwoPort


@dataclass(frozen=True, slots=True)
class PassiveHand:
    """A passive hand: m s + b + k/s, and the device's mass is in the loop already.

    Attributes:
        mass: kg.
        damping: N·s/m.
        stiffness: N/m.
    """

    mass: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0

    def impedance(self, frequencies: Real) -> Complex:
        """Z(jω), shape (f,), N·s/m.

        Raises:
            InputError: it has negative parts.
        """
        if min(self.mass, self.damping, self.stiffness) < 0:
            raise InputError("A hand's mass, damping and stiffness cannot be negative.")
        s = 1j * frequencies
        return self.mass * s + self.damping + self.stiffness / s


@dataclass(frozen=True, slots=True)
class Lawrence:
    """What the first user feels, N·s/m, shape (f,) each."""

    free: Complex
    held: Complex
    terminated: Complex

    def width(self) -> Real:
        """|Z_max| / |Z_min|, the range that can be told apart, shape (f,)."""
        return np.abs(self.held) / np.abs(self.free)


def lawrence(port: TwoPort, far: PassiveHand) -> Lawrence:
    """Z_min, Z_max and Z_t with a hand at the far port."""
    hybrid = port.hybrid
    h11, h12, h21, h22 = (hybrid[:, i, j] for i in (0, 1) for j in (0, 1))
    load = far.impedance(port.frequencies)
    return Lawrence(
        free=h11,
        held=h11 - h12 * h21 / h22,
        terminated=h11 - h12 * h21 * load / (1.0 + h22 * load),
    )


@dataclass(frozen=True, slots=True)
class Yokokohji:
    """The two indices.

    Attributes:
        position: J_p, (m/N)·(rad/s).
        force: J_f, rad/s.
    """

    position: float
    force: float


def yokokohji(
    port: TwoPort, near: PassiveHand, far: PassiveHand, highest: float, lag: float
) -> Yokokohji:
    """J_p and J_f.

    Args:
        port: the loop; its frequencies up to ``highest`` are integrated over, by trapezoids.
        near: the operator's passive impedance.
        far: the other hand's.
        highest: ω_m, rad/s.
        lag: T in s, of the weight 1/(1 + jωT).

    Raises:
        InputError: there are fewer than two frequencies up to ω_m.
    """
    taken = port.frequencies <= highest * (1 + 1e-12)
    if taken.sum() < 2:
        raise InputError(f"Up to {highest:g} rad/s there are no two frequencies to integrate over.")
    w = port.frequencies[taken]
    y = port.admittance[taken]
    hands = np.zeros_like(y)
    hands[:, 0, 0], hands[:, 1, 1] = near.impedance(w), far.impedance(w)
    # f = (f_op, 0) − Z v and v = Y f.
    forces = np.linalg.solve(np.eye(2) + hands @ y, np.array([[1.0], [0.0]]))
    velocities = y @ forces
    positions = velocities[:, :, 0] / (1j * w)[:, None]
    force_near, force_far = forces[:, 0, 0], -forces[:, 1, 0]
    weight = 1.0 / np.abs(1.0 + 1j * w * lag)
    return Yokokohji(
        _integral(np.abs(positions[:, 0] - positions[:, 1]) * weight, w),
        _integral(np.abs(force_near - force_far) * weight, w),
    )


def _integral(values: Real, over: Real) -> float:
    return float(np.sum((values[1:] + values[:-1]) * np.diff(over)) / 2.0)
