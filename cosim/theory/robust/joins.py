"""Common quadratic norms without a solver: quadratic forms are joined until they contract alike.

P_i ← I + γ⁻² ⊔_e MᵀP_jM over the edges i → j, where A ⊔ B = A + (B − A)₊ in the coordinates in
which A is the identity: a smallest form that is above both (Gaubert and Stott 2017, "tropical Kraus
maps"). Where this stays bounded, γ²P_i ⪰ MᵀP_jM along every edge. A step costs the cube of the
order where a semidefinite programme costs its sixth power. What a join loses is lost once a product
when the maps are products of k, and the k-th root is taken of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.theory.numerics import Real, solve
from cosim.theory.robust.automaton import Automaton, Edge

MOST_PRODUCTS = 40
"""That are joined."""
MOST_WORK = 64 * 62**3
"""Their number times the cube of their order."""
ROUNDS = 40
TRIALS = 8
BETWEEN = 0.01
"""How near the last γ that is proved and the last that is not may come."""
UNBOUNDED = 1e8
ROUNDING = 1.0 + 1e-9


@dataclass(frozen=True, slots=True)
class Products:
    """All products of ``length`` maps, each an edge of ``automaton``."""

    automaton: Automaton
    length: int


def joined_norms(automaton: Automaton, known: float) -> tuple[float, Real, Products]:
    """A bound of the joint spectral radius and the forms that prove it.

    Args:
        automaton: the maps, in coordinates of like size.
        known: a radius that no bound can be below.

    Returns:
        γ, P, shape (nodes, n, n), and the products of k maps that P contracts by γᵏ.
    """
    products, length = automaton, 1
    n = automaton.maps.shape[1]
    while True:
        longer = _times(products, automaton)
        count = len(longer.edges)
        if count > MOST_PRODUCTS or count * n**3 > MOST_WORK:
            break
        products, length = longer, length + 1
    start = np.array([np.eye(n)] * automaton.nodes)
    low, best, proof = known**length, _contraction(products, start, _images(products, start)), start
    for _ in range(TRIALS):
        if best <= max(low, 1e-300) * (1.0 + BETWEEN) ** length:
            break
        tried = float(np.sqrt(max(low, 1e-6 * best) * best))
        found = _bounded(products, start, tried)
        if found is None:
            low = tried
        else:
            best, proof = found
    return (best * ROUNDING) ** (1.0 / length), proof, Products(products, length)


def _times(products: Automaton, automaton: Automaton) -> Automaton:
    """Every product with every map that may follow it."""
    maps: list[Real] = []
    edges: list[Edge] = []
    for one in products.edges:
        for two in automaton.edges:
            if two.source == one.target:
                edges.append(Edge(one.source, two.target, len(maps)))
                maps.append(automaton.along(two) @ products.along(one))
    return Automaton(np.array(maps), tuple(edges), automaton.nodes)


def _bounded(products: Automaton, start: Real, radius: float) -> tuple[float, Real] | None:
    """A contraction near a radius and its forms; None where the forms grow without end."""
    n, norms = products.maps.shape[1], start
    for _ in range(ROUNDS):
        images = _images(products, norms)
        found = _contraction(products, norms, images)
        if found <= radius * (1.0 + BETWEEN / 4):
            return found, norms
        norms = np.array(
            [
                _joined(
                    np.eye(n),
                    [
                        image / radius**2
                        for edge, image in zip(products.edges, images, strict=True)
                        if edge.source == node
                    ],
                )
                for node in range(products.nodes)
            ]
        )
        if float(np.trace(norms[0])) > UNBOUNDED * n:
            return None
    return None


def _images(products: Automaton, norms: Real) -> list[Real]:
    along = [(products.along(edge), norms[edge.target]) for edge in products.edges]
    return [one.T @ form @ one for one, form in along]


def _contraction(products: Automaton, norms: Real, images: list[Real]) -> float:
    """The largest √λ_max(P_i⁻¹ MᵀP_jM)."""
    roots: Real = np.asarray(np.linalg.cholesky(norms), dtype=np.float64)
    squares = [
        float(np.linalg.eigvalsh(_seen(roots[edge.source], image))[-1])
        for edge, image in zip(products.edges, images, strict=True)
    ]
    return float(np.sqrt(max(*squares, 0.0)))


def _joined(found: Real, images: list[Real]) -> Real:
    for image in images:
        root: Real = np.asarray(np.linalg.cholesky(found), dtype=np.float64)
        values, vectors = np.linalg.eigh(_seen(root, image))
        above = values > 1.0
        lift = root @ vectors[:, above]
        found = found + (lift * (values[above] - 1.0)) @ lift.T
        found = (found + found.T) / 2.0
    return found


def _seen(root: Real, form: Real) -> Real:
    """A form in the coordinates in which that of a Cholesky factor is the identity."""
    half = solve(root, form)
    seen = solve(root, half.T)
    return (seen + seen.T) / 2.0
