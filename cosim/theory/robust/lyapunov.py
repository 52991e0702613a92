"""A common Lyapunov certificate: one quadratic norm a node that every map contracts by γ.

    γ² P_i − Mᵀ P_j M ⪰ t I   along every edge i → j,   P_i ⪰ t I,   Σ tr P_i = n · nodes,   max t.

With t > 0 the norms √(xᵀ P_i x) shrink by γ at least in every frame, whatever order the maps come
in: the joint spectral radius is at most γ (Ando and Shih 1998; for graphs Philippe et al. 2016).
What the solver returns is verified by Cholesky factors of our own, and counts only then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.numerics import Real, spectral_radius
from cosim.theory.robust.automaton import Automaton
from cosim.theory.robust.joins import joined_norms
from cosim.theory.robust.semidefinite import Block, maximise_margin, symmetric_basis

MOST_UNKNOWNS = 2000
"""Of a semidefinite programme, which takes their cube; larger norms are found by joins."""
SLACK = (0.0, 1e-8, 1e-6, 1e-4)
"""What rounding may add to a radius before its norms are verified."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Quadratic norms that prove a bound.

    Attributes:
        radius: γ, which no product of k maps exceeds by more than a constant times γᵏ.
        norms: P, shape (nodes, n, n), verified.
    """

    radius: float
    norms: Real

    def basis(self) -> Real:
        """T with P = TᵀT, upper triangular, shape (nodes, n, n)."""
        return np.asarray(np.linalg.cholesky(self.norms), dtype=np.float64).swapaxes(1, 2)


def certificate(automaton: Automaton, known: float, accuracy: float = 1e-4) -> Certificate:
    """The smallest γ with common quadratic norms, to ``accuracy`` (relative).

    Where the norms are too large for a semidefinite programme γ is one that joins prove, which is
    not the smallest.

    Args:
        automaton: the maps.
        known: a radius that no γ can be below: that of a closed product.
        accuracy: relative.

    Raises:
        InputError: the solver is not installed.
    """
    n = automaton.maps.shape[1]
    unknowns = automaton.nodes * n * (n + 1) // 2
    start = _start(automaton)
    level = automaton.in_basis(start)
    if unknowns > MOST_UNKNOWNS:
        radius, joined = _by_joins(level, known)
        return Certificate(radius, _in_coordinates(start, joined))
    low, high = known, max(float(np.linalg.norm(one, 2)) for one in level.maps)
    best = np.array([np.eye(n)] * level.nodes)
    # Most answers lie right above the best product: steps that grow fourfold from there.
    step = accuracy * max(low, 1e-3 * high)
    while high - low > 1.01 * accuracy * high:
        tried = min(low + step, (low + high) / 2)
        found = _norms_at(level, tried)
        if found is None:
            low, step = tried, 4 * step
        else:
            high, best, step = tried, found, (tried - low) / 2
    return Certificate(high, _in_coordinates(start, best))


def _in_coordinates(basis: Real, norms: Real) -> Real:
    return np.array([t.T @ p @ t for t, p in zip(basis, norms, strict=True)])


def _by_joins(level: Automaton, known: float) -> tuple[float, Real]:
    """γ and norms by joins, verified.

    Raises:
        InputError: rounding spoils every proof.
    """
    radius, norms, products = joined_norms(level, known)
    for slack in SLACK:
        found = radius * (1.0 + slack)
        if verified(products.automaton, norms, found**products.length):
            return found, norms
    raise InputError(
        f"No common norms of order {level.maps.shape[1]} could be verified: take shorter delays or "
        "bursts, or losses together."
    )


def verified(automaton: Automaton, norms: Real, radius: float) -> bool:
    """Whether γ² P_i − Mᵀ P_j M has a Cholesky factor along every edge, and every P_i has."""
    scaled = [norms[e.target] for e in automaton.edges]
    falls = [
        radius**2 * norms[e.source] - automaton.along(e).T @ p @ automaton.along(e)
        for e, p in zip(automaton.edges, scaled, strict=True)
    ]
    try:
        for matrix in (*norms, *falls):
            np.linalg.cholesky((matrix + matrix.T) / 2)
    except np.linalg.LinAlgError:
        return False
    return True


def _norms_at(automaton: Automaton, radius: float) -> Real | None:
    n, nodes = automaton.maps.shape[1], automaton.nodes
    basis = symmetric_basis(n)
    size = len(basis)
    blocks: list[Block] = []
    for edge in automaton.edges:
        one = automaton.along(edge)
        into = -np.einsum("ba,kbc,cd->kad", one, basis, one)
        effect = np.zeros((nodes * size, n, n))
        effect[edge.source * size : (edge.source + 1) * size] += radius**2 * basis
        effect[edge.target * size : (edge.target + 1) * size] += into
        blocks.append(Block(effect))
    for node in range(nodes):
        effect = np.zeros((nodes * size, n, n))
        effect[node * size : (node + 1) * size] = basis
        blocks.append(Block(effect))
    trace = np.tile(np.trace(basis, axis1=1, axis2=2), nodes)
    found = maximise_margin(blocks, trace, float(n * nodes))
    norms = np.einsum("nk,kab->nab", found.reshape(nodes, size), basis)
    return norms if verified(automaton, norms, radius) else None


def _start(automaton: Automaton) -> Real:
    """Coordinates in which all maps are of like size: Σ_k (M̄/r)ᵏᵀ (M̄/r)ᵏ of their mean."""
    mean = automaton.maps.mean(axis=0)
    scale = 1.02 * max(
        spectral_radius(mean), *(spectral_radius(one) for one in automaton.maps), 1e-6
    )
    total = np.eye(len(mean))
    step = mean / scale
    for _ in range(12):
        # The sum over 2k terms from that over k.
        total = total + step.T @ total @ step
        step = step @ step
    total /= np.trace(total) / len(total)
    total += 1e-9 * np.eye(len(total))
    basis = np.asarray(np.linalg.cholesky(total), dtype=np.float64).T
    return np.repeat(basis[None], automaton.nodes, axis=0)
