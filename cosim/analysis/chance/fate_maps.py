"""The map of every fate, and what second moments make of them.

With maps M_e and a chain that chooses between them, the second moments X_i = E[x xᵀ 1(mode i)]
follow X_j ← Σ p(i, e → j) M_e X_i M_eᵀ, and the run is mean-square stable exactly where the
spectral radius of that is below 1 (Costa, Fragoso and Marques 2005, theorem 3.9).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.chain import Chain
from cosim.analysis.chance.fate import PeriodFate
from cosim.analysis.chance.second_moments import SecondMoments
from cosim.analysis.monodromy.blocks import connected_blocks, dropped
from cosim.analysis.monodromy.jacobian import jacobian
from cosim.analysis.monodromy.neutral import quotient
from cosim.analysis.monodromy.point import Point
from cosim.base.errors import InputError
from cosim.theory.numerics import largest_eigenvalue_of_map, spectral_radius

Real = NDArray[np.float64]

MOST_OUTCOMES = 400
DENSE = 150
"""Up to so many second moments their map is formed."""


@dataclass(frozen=True, slots=True)
class FateMaps:
    """The maps of a run.

    Attributes:
        outcomes: per map, the fate on every link.
        maps: dΦ/dx of each outcome on all coordinates, shape (outcomes, n, n).
        blocks: per strongly connected block, the maps on its quotient, shape (outcomes, m, m).
    """

    outcomes: tuple[tuple[PeriodFate, ...], ...]
    maps: Real
    blocks: tuple[Real, ...]

    def mean_square_radius(self, chain: Chain) -> float:
        """ρ of the second moments over one period; its root compares with the radius of a map."""
        numbers = self._numbers(chain)
        return max((_radius(maps, chain, numbers) for maps in self.blocks), default=0.0)

    def surely_decays(self, chain: Chain) -> bool:
        """Whether few periods show that second moments decay; if not, they may all the same."""
        numbers = self._numbers(chain)
        return all(SecondMoments(maps, chain, numbers).surely_decay() for maps in self.blocks)

    def _numbers(self, chain: Chain) -> list[int]:
        place = {outcome: number for number, outcome in enumerate(self.outcomes)}
        return [place[step.fates] for step in chain.steps]


def links_of(point: Point) -> tuple[str, ...]:
    """What crosses channels, ``channel.direction``, in the order of the run's bundles.

    Raises:
        InputError: nothing does, or a channel does not send once in the hyperperiod.
    """
    bundles = [b.bundle for b in point.run.bundles if b.bundle.channel is not None]
    if not bundles:
        raise InputError("Nothing crosses a channel, so that there are no packets to lose.")
    if any(bundle.period != point.run.hyperperiod for bundle in bundles):
        raise InputError(
            "Loss and jitter are asked for where every channel sends once in the hyperperiod: give "
            "the channels one rate that divides the control rate."
        )
    return tuple(bundle.name for bundle in bundles)


def fate_maps(point: Point, chain: Chain) -> FateMaps:
    """The derivative of Φ for every outcome of a chain, the links in the order of ``links_of``.

    Raises:
        InputError: there are too many, or one has no derivative.
    """
    outcomes = chain.outcomes
    if len(outcomes) > MOST_OUTCOMES:
        raise InputError(
            f"What may become of packets makes {len(outcomes)} maps, and up to {MOST_OUTCOMES} are "
            "made: give jitter whole samples, fewer of them, or ask with --losses together."
        )
    numbers = [b.number for b in point.run.bundles if b.bundle.channel is not None]
    maps = [
        jacobian(point.run, fates=dict(zip(numbers, outcome, strict=True))) for outcome in outcomes
    ]
    return FateMaps(outcomes, np.array(maps), _blocks(point, maps))


def _blocks(point: Point, maps: list[Real]) -> tuple[Real, ...]:
    run = point.run
    kept = ~dropped(maps)
    found: list[Real] = []
    for block in connected_blocks(maps, kept):
        size = run.steps[block]
        inner = [one[np.ix_(block, block)] * size[None, :] / size[:, None] for one in maps]
        if block.size == 1 and (
            not any(one.any() for one in inner) or all(one[0, 0] == 1.0 for one in inner)
        ):
            continue
        units = [run.coordinates[number].unit for number in map(int, block)]
        if run.is_linear:
            inner = [one[np.ix_(block, block)] for one in maps]
        found.append(np.array(quotient(inner, units, is_linear=run.is_linear).maps))
    return tuple(found)


def _radius(maps: Real, chain: Chain, numbers: Sequence[int]) -> float:
    if len(set(numbers)) == 1:
        return spectral_radius(maps[numbers[0]]) ** 2
    moments = SecondMoments(maps, chain, numbers)
    start = moments.identity
    if start.size <= DENSE:
        return spectral_radius(np.array([moments.apply(one) for one in np.eye(start.size)]).T)
    return largest_eigenvalue_of_map(moments.apply, start, accuracy=1e-7)
