"""The loop between two users as a two-port, and whether every pair of passive hands is safe in it.

Forces act on both hands, held over T_t; what answers is the distance that a hand moves in T_t over
T_t, so that force times velocity is the power that flows (the velocity at the frame's start is
not: a free mass would look active). v = Y f, at z = e^{jωT_t}, 0 < ω ≤ π/T_t.

The two-port is *absolutely stable*, stable with every pair of passive terminations, exactly where
(Llewellyn 1952) it is stable with free ports and at every frequency

    Re y₁₁ ≥ 0,   Re y₂₂ ≥ 0,   2 Re y₁₁ Re y₂₂ ≥ |y₁₂ y₂₁| + Re(y₁₂ y₂₁),

which reads the same in z, y, h and g parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import Frame
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Bool, Complex, Real, solve_complex
from cosim.theory.stability.spectral_radius import stability

ROUNDING = 1e-9
"""Relative; a lossless port has Re y = 0, and rounding puts it on either side."""


@dataclass(frozen=True, slots=True)
class TwoPort:
    """Admittance between two users' hands.

    Attributes:
        frequencies: shape (f,), rad/s.
        admittance: Y, shape (f, 2, 2), m/(N·s).
        stable: with nothing at its ports.
    """

    frequencies: Real
    admittance: Complex
    stable: bool

    @property
    def hybrid(self) -> Complex:
        """H with (f₁, −v₂) = H (v₁, f₂), shape (f, 2, 2)."""
        (y11, y12), (y21, y22) = _parts(self.admittance)
        determinant = y11 * y22 - y12 * y21
        rows = [np.stack([1 / y11, -y12 / y11], -1), np.stack([-y21 / y11, -determinant / y11], -1)]
        return np.asarray(np.stack(rows, axis=-2), dtype=np.complex128)

    @property
    def impedance(self) -> Complex:
        """Z = Y⁻¹, shape (f, 2, 2), N·s/m."""
        return np.asarray(np.linalg.inv(self.admittance), dtype=np.complex128)

    def llewellyn(self) -> Real:
        """The stability parameter per frequency, shape (f,): absolutely stable at 1 and above.

        η = (2 Re y₁₁ Re y₂₂ − Re(y₁₂ y₂₁)) / |y₁₂ y₂₁|; −∞ where a port alone is active, +∞ where
        nothing passes.
        """
        (y11, y12), (y21, y22) = _parts(self.admittance)
        through = np.abs(y12 * y21)
        own = _not_active(y11) & _not_active(y22)
        product = 2 * np.maximum(y11.real, 0) * np.maximum(y22.real, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(
                through > 0,
                (product - (y12 * y21).real) / np.where(through > 0, through, 1),
                np.inf,
            )
        return np.where(own, ratio, -np.inf)

    def absolutely_stable(self) -> bool:
        """Llewellyn's conditions, at the frequencies that were asked for."""
        return self.stable and bool(np.all(self.llewellyn() >= 1.0 - ROUNDING))

    def damping_for_absolute_stability(self) -> float:
        """The smallest damping at each port (N·s/m) with which the conditions hold, or 0.

        b in series with both ports: 2 (r₁ + b)(r₂ + b) ≥ |z₁₂ z₂₁| + Re(z₁₂ z₂₁), r + b ≥ 0.
        """
        (z11, z12), (z21, z22) = _parts(self.impedance)
        one, two = z11.real, z22.real
        through = (np.abs(z12 * z21) + (z12 * z21).real) / 2
        larger = -(one + two) / 2 + np.sqrt(((one - two) / 2) ** 2 + through)
        needed = np.maximum(larger, np.maximum(-one, -two))
        return max(0.0, float(needed.max()))


def two_port(model: Model, timing: Timing, frequencies: Real) -> TwoPort:
    """The two-port between the first user and the second.

    Args:
        model: the loop of two users, both hands in it.
        timing: rates and delay; a whole ratio.
        frequencies: rad/s, shape (f,), above 0 and up to π/T_t.

    Raises:
        InputError: the loop has not two hands, or a frequency is out of range.
    """
    if model.users != 2 or not all(model.present):
        raise InputError("A two-port lies between two users: take --users 2, both holding.")
    limit = np.pi / float(timing.network_period)
    if np.any(frequencies <= 0) or np.any(frequencies > limit * (1 + 1e-12)):
        raise InputError(f"Frequencies of a two-port are above 0 and up to {limit:.6g} rad/s.")
    frame = assemble(model, timing).frame()
    push = np.array([frame.force_over_frame(frame.force_on_hand[s]) for s in (0, 1)]).T
    read = np.zeros((2, len(frame.map)))
    for port, place in enumerate(frame.hand[:2]):
        assert place is not None
        read[port, place] = 1.0
    period = float(timing.network_period)
    found = [_moved(frame, push, read, np.exp(1j * w * period)) / period for w in frequencies]
    return TwoPort(frequencies, np.array(found), stability(model, timing).stable)


def _moved(frame: Frame, push: Real, read: Real, z: complex) -> Complex:
    """Distances moved in a frame, over forces: (z − 1) C (zI − M)⁻¹ B, shape (2, 2)."""
    resolvent = np.asarray(z * np.eye(len(frame.map)) - frame.map, dtype=np.complex128)
    return (z - 1) * (read @ solve_complex(resolvent, push))


def _parts(two: Complex) -> tuple[tuple[Complex, Complex], tuple[Complex, Complex]]:
    return (two[:, 0, 0], two[:, 0, 1]), (two[:, 1, 0], two[:, 1, 1])


def _not_active(one: Complex) -> Bool:
    return one.real >= -ROUNDING * np.abs(one)


def default_frequencies(timing: Timing, count: int = 400) -> Real:
    """From 0.1 rad/s to just below π/T_t, where nothing moves over a frame; shape (count,)."""
    return np.geomspace(0.1, 0.99 * np.pi / float(timing.network_period), count)
