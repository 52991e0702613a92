"""Motions that are neutral whatever the gains: everything moved alike, everything at one speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cosim.theory.numerics import Bool, Real, eigenvalues

EXACT = 1e-12
"""How exactly a map must leave a neutral motion as it is where everything is linear."""
DIFFERENCED = 1e-8
"""The same where the map comes from differences of small steps."""
NEAR_ONE = 1e-9
_MOST = 12


@dataclass(frozen=True, slots=True)
class Quotient:
    """Maps on what is left when neutral motions are taken out.

    Attributes:
        maps: each shape (m, m).
        lift: shape (n, m): a representative of each coordinate that is left.
        neutral: how many motions were taken out.
        marginal: whether a common velocity was neutral too (momentum is conserved).
    """

    maps: tuple[Real, ...]
    lift: Real
    neutral: int
    marginal: bool


def quotient(maps: Sequence[Real], units: Sequence[str], *, is_linear: bool) -> Quotient:
    """Take out the translation, a velocity that is conserved, and gauges of travelling integrals.

    A translation moves every position by as much, and is taken out where all maps leave it exactly
    as it is; nothing does where a wall or a hand's own spring holds. Waves travel as integrals, of
    which only differences count.
    """
    tolerance = EXACT if is_linear else DIFFERENCED
    shift = np.array([1.0 if unit == "m" else 0.0 for unit in units])
    found = tuple(maps)
    lift = np.eye(found[0].shape[0])
    neutral = 0
    translated = shift.any() and all(_leaves(one, shift, tolerance) for one in found)
    if translated:
        lift = lift @ _complement(shift)
        found = tuple(_without(one, shift) for one in found)
        neutral += 1
    integral = np.array([unit == "N.s" for unit in units])
    if integral.any():
        for _ in range(_MOST):
            gauge = _gauge(found, lift, integral, tolerance)
            if gauge is None:
                break
            lift = lift @ _complement(gauge)
            found = tuple(_without(one, gauge) for one in found)
            neutral += 1
    marginal = False
    if translated and neutral == 1 and len(found) == 1:
        common = _common_velocity(maps[0], shift, tolerance)
        if common is not None:
            reduced = _coordinates_of(common, shift)
            lift = lift @ _complement(reduced)
            found = (_without(found[0], reduced),)
            neutral += 1
            marginal = True
    return Quotient(found, lift, neutral, marginal)


def _leaves(matrix: Real, vector: Real, tolerance: float) -> bool:
    return bool(np.max(np.abs(matrix @ vector - vector)) <= tolerance * np.max(np.abs(vector)))


def _complement(vector: Real) -> Real:
    """The identity without the column of the vector's largest entry, shape (n, n - 1)."""
    return np.delete(np.eye(vector.size), int(np.argmax(np.abs(vector))), axis=1)


def _coordinates_of(vector: Real, taken: Real) -> Real:
    """A vector's coordinates on the quotient by another."""
    pivot = int(np.argmax(np.abs(taken)))
    return np.delete(vector - taken * (vector[pivot] / taken[pivot]), pivot)


def _without(matrix: Real, vector: Real) -> Real:
    """The map on the quotient by a vector that it leaves as it is."""
    pivot = int(np.argmax(np.abs(vector)))
    rest = np.delete(np.arange(vector.size), pivot)
    row = matrix[pivot, rest]
    return matrix[np.ix_(rest, rest)] - np.outer(vector[rest] / vector[pivot], row)


def _gauge(maps: tuple[Real, ...], lift: Real, integral: Bool, tolerance: float) -> Real | None:
    """A motion of travelling integrals alone that all maps leave as it is."""
    values, vectors = np.linalg.eig(maps[0])
    for number in np.argsort(np.abs(values - 1.0))[:_MOST]:
        if abs(values[number] - 1.0) > 1e-6:
            break
        for part in (np.real(vectors[:, number]), np.imag(vectors[:, number])):
            full = lift @ part
            size = np.max(np.abs(full), initial=0.0)
            elsewhere = np.max(np.abs(full[~integral]), initial=0.0)
            if size == 0.0 or elsewhere > 1e-6 * size:
                continue
            alone = np.where(np.abs(part) > 1e-9 * np.max(np.abs(part)), part, 0.0)
            if all(_leaves(one, alone, 100 * tolerance) for one in maps):
                return np.asarray(alone)
    return None


def _common_velocity(matrix: Real, shift: Real, tolerance: float) -> Real | None:
    """W with (M − I) w = t: a motion that translates further every hyperperiod, or none."""
    near = np.abs(eigenvalues(_without(matrix, shift)) - 1.0)
    if near.size == 0 or float(np.min(near)) > max(NEAR_ONE, tolerance):
        return None
    apart = matrix - np.eye(shift.size)
    motion = np.linalg.lstsq(apart, shift, rcond=1e-13)[0]
    if np.linalg.norm(apart @ motion - shift) > 1e-6 * np.linalg.norm(shift):
        return None
    return np.asarray(motion, dtype=np.float64)
