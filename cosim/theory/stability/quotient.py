"""Removing the motions that are always neutral: common translation, common velocity where free.

λ = 1 is an exact eigenvalue of every loop that nothing ties to the ground, because everything may
be moved by the same distance. (3.19)'s |λ| ≤ 1 and (4.30)'s "all inside" both stumble over it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.theory.numerics import Complex, Real, eigenvalues

MOMENTUM_TOLERANCE = 1e-9
"""How near 1 the common-velocity eigenvalue counts as 1: its size is 1 − b T_t / Σm, so this is a
net damping below about 1e-7 N·s/m."""


def without_translation(frame_map: Real, translation: Real) -> Real:
    """The map on the quotient by a fixed vector.

    Args:
        frame_map: M, shape (n, n) or a stack (..., n, n), with M t = t.
        translation: t, shape (n,).

    Returns:
        Shape (..., n−1, n−1), with M's eigenvalues less one λ = 1.
    """
    pivot = int(np.argmax(translation != 0.0))
    rest = np.delete(np.arange(translation.size), pivot)
    inner = frame_map[..., rest[:, None], rest[None, :]]
    row = frame_map[..., pivot, rest]
    scaled = translation[rest] / translation[pivot]
    return inner - scaled[:, None] * row[..., None, :]


@dataclass(frozen=True, slots=True)
class Spectrum:
    """The eigenvalues that decide stability.

    Attributes:
        values: all but the neutral motions, largest first.
        marginal: whether the common velocity was neutral too (momentum is conserved) and removed.
    """

    values: Complex
    marginal: bool

    @property
    def radius(self) -> float:
        """The spectral radius of what is left; 0 where nothing is left."""
        return float(np.abs(self.values[0])) if self.values.size else 0.0


def decisive_spectrum(frame_map: Real, translation: Real | None) -> Spectrum:
    """Eigenvalues after the quotient by translation and, where momentum is conserved, velocity.

    Args:
        frame_map: shape (n, n).
        translation: shape (n,), or None where something holds the position.
    """
    if translation is None:
        values = eigenvalues(frame_map)
        return Spectrum(values[np.argsort(-np.abs(values))], marginal=False)
    values = eigenvalues(without_translation(frame_map, translation))
    distance = np.abs(values - 1.0)
    nearest = int(np.argmin(distance)) if values.size else -1
    marginal = (
        values.size > 0
        and float(distance[nearest]) < MOMENTUM_TOLERANCE
        and _common_velocity_is_neutral(frame_map, translation)
    )
    if marginal:
        values = np.delete(values, nearest)
    return Spectrum(values[np.argsort(-np.abs(values))], marginal=marginal)


def _common_velocity_is_neutral(frame_map: Real, translation: Real) -> bool:
    """Whether (M − I) w = t has a solution: a motion that translates further every frame.

    A second λ = 1 without it is another neutral motion, such as two copies that nothing ties
    together, and is no reason to call the loop stable.
    """
    scale = np.where(np.abs(translation) > 1.0, np.abs(translation), 1.0)
    balanced = frame_map * (scale[None, :] / scale[:, None]) - np.eye(translation.size)
    target = translation / scale
    solution = np.linalg.lstsq(balanced, target, rcond=1e-13)[0]
    residual = float(np.linalg.norm(balanced @ solution - target))
    return residual < 1e-6 * float(np.linalg.norm(target))
