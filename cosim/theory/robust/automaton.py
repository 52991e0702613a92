"""Which maps may follow each other: a graph whose edges are one-frame maps.

A loop whose map is chosen anew every frame by an adversary has one node, and every map is an edge
from it to itself. Where choices depend on what came before (at most L losses in a row), each node
is what must be remembered of it (Philippe, Essick, Dullerud and Jungers 2016).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.theory.numerics import Real, solve


@dataclass(frozen=True, slots=True)
class Edge:
    """A frame that leads from one node to another."""

    source: int
    target: int
    map: int


@dataclass(frozen=True, slots=True)
class Automaton:
    """Maps x⁺ = M x, and the order in which they may come.

    Attributes:
        maps: shape (maps, n, n).
        edges: which map leads from where to where.
        nodes: how many there are.
    """

    maps: Real
    edges: tuple[Edge, ...]
    nodes: int = 1

    def along(self, edge: Edge) -> Real:
        """The map of an edge, shape (n, n)."""
        return self.maps[edge.map]

    def in_basis(self, basis: Real) -> Automaton:
        """The same with y = T_i x in node i, so that every edge has its own map.

        Args:
            basis: T, shape (nodes, n, n), invertible.
        """
        moved = [
            solve(basis[edge.source].T, (basis[edge.target] @ self.along(edge)).T).T
            for edge in self.edges
        ]
        edges = tuple(Edge(e.source, e.target, number) for number, e in enumerate(self.edges))
        return Automaton(np.array(moved), edges, self.nodes)


def arbitrary(maps: Real) -> Automaton:
    """Any map after any other.

    Args:
        maps: shape (maps, n, n).
    """
    return Automaton(maps, tuple(Edge(0, 0, number) for number in range(len(maps))))
