"""Bounds of the joint spectral radius by branch and bound (Gripenberg 1996).

    max_{|w| = k, closed} ρ(M_w)^{1/k}  ≤  ρ̂  ≤  any γ such that all long products are below γᵏ.

Products grow letter by letter. A branch ends where its norm (the smallest ‖M_v‖^{1/|v|} of its
beginnings) is below the best product found plus the accuracy; what is left after the last level
gives the upper bound. In the norm of a Lyapunov certificate few branches survive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.theory.numerics import Real, spectral_radius
from cosim.theory.robust.automaton import Automaton
from cosim.theory.robust.lyapunov import certificate
from cosim.theory.robust.reduction import reduced

Whole = NDArray[np.intp]

MOST_PRODUCTS = 60_000
"""Products on one level; the search ends before it would multiply more."""
FEW_PRODUCTS = 3_000
"""The same once the bounds lie on one side of 1."""
LARGE = 40
"""The order above which fewer products are multiplied, by the cube that each costs."""
SEARCHED = 24
"""The order on which short products are searched for."""
SHORT = 8
"""Maps of a short product."""


@dataclass(frozen=True, slots=True)
class JointRadius:
    """Bounds of the joint spectral radius, per map.

    Attributes:
        lower: ρ(M_w)^{1/k} of ``word``: this growth happens.
        upper: no sequence grows faster.
        quadratic: what common quadratic norms prove alone; at least ``upper``.
        word: maps in the order in which they come, to be repeated for ever.
        depth: length of the longest products that were looked at.
    """

    lower: float
    upper: float
    quadratic: float
    word: tuple[int, ...]
    depth: int

    @property
    def verdict(self) -> str:
        """``stable`` whatever comes, ``unstable`` by the word, or ``undecided``."""
        if self.upper < 1.0:
            return "stable"
        return "unstable" if self.lower >= 1.0 else "undecided"


def joint_radius(automaton: Automaton, accuracy: float = 1e-4, deepest: int = 40) -> JointRadius:
    """Bounds of the joint spectral radius of maps in an automaton's order.

    Args:
        automaton: the maps.
        accuracy: wanted distance of the bounds, relative to the radius. Where the products become
            too many the bounds stay wider.
        deepest: longest products.

    Raises:
        InputError: the solver of the certificate is not installed.
    """
    lower, word = _best_short_product(automaton)
    # Where a product already grows, nothing is left to prove to the last digit.
    proved = certificate(automaton, lower, accuracy if lower < 1.0 else 10 * accuracy)
    level = automaton.in_basis(proved.basis())
    gap = accuracy * proved.radius
    leaving = _leaving(level)
    found = _Branches.roots(level)
    upper, depth = proved.radius, 1
    while True:
        radius, best = found.best_cycle()
        if radius > lower * (1 + 1e-9):
            lower, word = radius, best
        kept = found.above(lower + gap)
        upper = min(upper, max(lower + gap, kept.highest()))
        growth = max((len(ways) for ways in leaving), default=1)
        decided = upper < 1.0 or lower >= 1.0
        if (
            kept.size == 0
            or depth == deepest
            or kept.size * growth > _room(automaton, FEW_PRODUCTS if decided else MOST_PRODUCTS)
        ):
            maps = tuple(automaton.edges[edge].map for edge in word)
            return JointRadius(lower, max(upper, lower), proved.radius, maps, depth)
        found, depth = kept.grown(level, leaving), depth + 1


def _room(automaton: Automaton, most: int) -> int:
    """How many products are multiplied on a level."""
    return max(2 * SEARCHED, int(most * min(1.0, (LARGE / automaton.maps.shape[1]) ** 3)))


def _best_short_product(automaton: Automaton) -> tuple[float, tuple[int, ...]]:
    """The closed product with the largest ρ^{1/k} among all that are short, and its edges.

    Of maps of a large order the short products of their reduction say which to take.
    """
    found = [(_growth(automaton, word), word) for word in _best_words(reduced(automaton, SEARCHED))]
    return max(found, default=(0.0, ()))


def _growth(automaton: Automaton, word: tuple[int, ...]) -> float:
    product = np.eye(automaton.maps.shape[1])
    for edge in word:
        product = automaton.along(automaton.edges[edge]) @ product
    return spectral_radius(product) ** (1.0 / len(word))


def _best_words(automaton: Automaton) -> list[tuple[int, ...]]:
    """Of every short length the closed word that grows most, if more than all shorter ones."""
    lower, words = 0.0, list[tuple[int, ...]]()
    leaving = _leaving(automaton)
    found = _Branches.roots(automaton)
    for _ in range(SHORT):
        radius, best = found.best_cycle()
        if radius > lower * (1 + 1e-9):
            lower = radius
            words.append(best)
        if found.size * max(map(len, leaving)) > FEW_PRODUCTS:
            break
        found = found.grown(automaton, leaving)
    return words


def _leaving(automaton: Automaton) -> list[list[int]]:
    """Per node, the edges that leave it."""
    return [
        [number for number, e in enumerate(automaton.edges) if e.source == node]
        for node in range(automaton.nodes)
    ]


@dataclass(frozen=True, slots=True)
class _Branches:
    """All products of one length that may still grow.

    Attributes:
        products: shape (branches, n, n).
        bounds: the smallest ‖·‖^{1/j} of each one's beginnings, shape (branches,).
        words: the edges, shape (branches, length).
        start: the node in which each begins, shape (branches,).
        end: the node in which it ends, shape (branches,).
    """

    products: Real
    bounds: Real
    words: Whole
    start: Whole
    end: Whole

    @staticmethod
    def roots(level: Automaton) -> _Branches:
        maps = level.maps[[edge.map for edge in level.edges]]
        return _Branches(
            maps,
            np.linalg.norm(maps, 2, axis=(1, 2)),
            np.arange(len(maps))[:, None],
            np.array([edge.source for edge in level.edges]),
            np.array([edge.target for edge in level.edges]),
        )

    @property
    def size(self) -> int:
        return len(self.products)

    def highest(self) -> float:
        return float(self.bounds.max(initial=0.0))

    def best_cycle(self) -> tuple[float, tuple[int, ...]]:
        """The closed product with the largest ρ^{1/k}."""
        closed = np.nonzero(self.start == self.end)[0]
        if closed.size == 0:
            return 0.0, ()
        radii = np.abs(np.linalg.eigvals(self.products[closed])).max(axis=1)
        best = int(np.argmax(radii))
        word = tuple(int(edge) for edge in self.words[closed[best]])
        return float(radii[best]) ** (1.0 / len(word)), word

    def above(self, level: float) -> _Branches:
        kept = self.bounds > level
        return _Branches(
            self.products[kept], self.bounds[kept], self.words[kept], self.start[kept],
            self.end[kept],
        )  # fmt: skip

    def grown(self, level: Automaton, leaving: list[list[int]]) -> _Branches:
        origin = np.concatenate(
            [np.full(len(leaving[int(end)]), number) for number, end in enumerate(self.end)]
        ).astype(np.intp)
        edges = np.concatenate([leaving[int(end)] for end in self.end]).astype(np.intp)
        maps = level.maps[[level.edges[int(edge)].map for edge in edges]]
        products = maps @ self.products[origin]
        words = np.hstack([self.words[origin], edges[:, None]])
        norms = np.linalg.norm(products, 2, axis=(1, 2)) ** (1.0 / words.shape[1])
        end = np.array([level.edges[int(edge)].target for edge in edges])
        return _Branches(
            products, np.minimum(self.bounds[origin], norms), words, self.start[origin], end
        )
