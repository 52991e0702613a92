"""The eigenvalues of a run's map that decide its stability, and who takes part in them."""

from __future__ import annotations

import cmath
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.blocks import connected_blocks, dropped
from cosim.analysis.monodromy.neutral import DIFFERENCED, quotient
from cosim.analysis.monodromy.run_map import Coordinate
from cosim.theory.numerics import Complex, Real

SETTLED = 1e-12
"""ρ must be below 1 by more than this."""
_UNSEEN = 1e-9


@dataclass(frozen=True, slots=True)
class RunMode:
    """One eigenvalue, or a pair of them.

    Attributes:
        value: over the stated period.
        growth: σ (1/s); below 0 it decays.
        frequency: ω (rad/s).
        participation: the share of each owner's coordinates, largest first; the shares sum to 1.
        shape: the right eigenvector on all coordinates of the run, shape (n,).
    """

    value: complex
    growth: float
    frequency: float
    participation: Mapping[str, float]
    shape: Complex


@dataclass(frozen=True, slots=True)
class RunSpectrum:
    """What decides.

    Attributes:
        period: over which the radius is stated (s).
        radius: the largest magnitude over that period, neutral motions apart.
        neutral: how many motions are neutral whatever the gains.
        marginal: whether momentum is conserved, so that the common velocity was taken out too.
        modes: largest first; of a complex pair the one with positive frequency.
    """

    period: Fraction
    radius: float
    neutral: int
    marginal: bool
    modes: tuple[RunMode, ...]

    @property
    def stable(self) -> bool:
        """ρ < 1, by more than rounding makes of a neutral motion."""
        return self.radius < 1.0 - SETTLED

    @property
    def verdict(self) -> Literal["stable", "neutral", "unstable"]:
        """In a word.

        Neutral: the motion that decides neither decays nor grows as far as differences tell, such
        as a box that is held by hands without stiffness, along the way that nothing holds.
        """
        if self.stable:
            return "stable"
        return "neutral" if self.radius <= 1.0 + DIFFERENCED else "unstable"


def spectrum(
    matrix: Real,
    coordinates: Sequence[Coordinate],
    *,
    seconds: Fraction,
    period: Fraction,
    is_linear: bool,
    with_modes: bool = False,
) -> RunSpectrum:
    """The spectrum of a map over ``seconds``, stated over ``period`` (s)."""
    size = np.array([one.step for one in coordinates])
    balanced = matrix * size[None, :] / size[:, None] if size.size else matrix
    kept = ~dropped([matrix])
    radius, neutral, marginal = 0.0, 0, False
    modes: list[RunMode] = []
    share = float(period / seconds)
    for block in connected_blocks([matrix], kept):
        units = [coordinates[number].unit for number in map(int, block)]
        inner = balanced[np.ix_(block, block)] if not is_linear else matrix[np.ix_(block, block)]
        if block.size == 1 and inner[0, 0] in {0.0, 1.0}:
            # An integrator in no loop: a body that nothing holds or drives on.
            neutral += int(inner[0, 0])
            continue
        left = quotient([inner], units, is_linear=is_linear)
        neutral += left.neutral
        marginal = marginal or left.marginal
        values = np.linalg.eigvals(left.maps[0])
        radius = max(radius, float(np.max(np.abs(values), initial=0.0)))
        if with_modes:
            shapes = (block, left.lift, size if not is_linear else np.ones_like(size))
            modes += [
                replace(mode, shape=_everywhere(matrix, mode, float(seconds / period)))
                for mode in _modes(left.maps[0], shapes, coordinates, float(seconds), share)
            ]
    modes.sort(key=lambda mode: -abs(mode.value))
    return RunSpectrum(period, radius**share, neutral, marginal, tuple(modes))


def _everywhere(matrix: Real, mode: RunMode, share: float) -> Complex:
    """The shape on what follows the block as well, which answers within a hyperperiod or two."""
    value, shape = mode.value**share, mode.shape
    for _ in range(2):
        shape = (matrix @ shape) / value
    return shape


def _modes(
    reduced: Real,
    place: tuple[NDArray[np.int64], Real, Real],
    coordinates: Sequence[Coordinate],
    seconds: float,
    share: float,
) -> list[RunMode]:
    block, lift, size = place
    values, right = np.linalg.eig(reduced)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        left = np.linalg.pinv(right)
    found: list[RunMode] = []
    for number, value in enumerate(values):
        if abs(value) < _UNSEEN or value.imag < 0.0:
            continue
        taking = np.abs(left[number, :] * right[:, number])
        on_all = np.abs(lift) @ taking
        shares: dict[str, float] = {}
        for weight, index in zip(on_all / max(float(on_all.sum()), 1e-300), block, strict=True):
            owner = coordinates[int(index)].owner
            shares[owner] = shares.get(owner, 0.0) + float(weight)
        shape = np.zeros(len(coordinates), dtype=np.complex128)
        index = np.asarray(block, dtype=np.int64)
        shape[index] = (lift @ right[:, number]) * size[index]
        rate = cmath.log(complex(value)) / seconds
        found.append(
            RunMode(
                value=complex(cmath.exp(rate * seconds * share)),
                growth=rate.real,
                frequency=abs(rate.imag),
                participation=dict(sorted(shares.items(), key=lambda item: -item[1])),
                shape=shape,
            )
        )
    return found
