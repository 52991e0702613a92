"""What of a map decides stability: its strongly connected blocks, without what only remembers.

Perturbing a number leaves what does not depend on it the same to the last bit, so that zeros and
ones of a difference matrix are exact, and its structure can be read from it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.theory.numerics import Real


def dropped(maps: Sequence[Real]) -> NDArray[np.bool_]:
    """Which coordinates only remember or are never read, in all maps alike.

    A row of the identity is a memory that nothing changes (a contact's anchor): it is λ = 1, the
    choice of an equilibrium. A column of it is an integrator that nothing reads (an observed
    energy). Both are taken away until none is left.
    """
    size = maps[0].shape[0]
    kept = np.ones(size, dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        for number in np.flatnonzero(kept):
            others = kept.copy()
            others[number] = False
            if all(m[number, number] == 1.0 for m in maps) and (
                all(not m[number, others].any() for m in maps)
                or all(not m[others, number].any() for m in maps)
            ):
                kept[number] = False
                changed = True
    return ~kept


def connected_blocks(maps: Sequence[Real], kept: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The coordinates of each strongly connected block, the largest first."""
    places = np.flatnonzero(kept)
    if places.size == 0:
        return []
    linked = np.zeros((places.size, places.size), dtype=np.bool_)
    for matrix in maps:
        linked |= matrix[np.ix_(places, places)] != 0.0
    reached = _closure(linked)
    together = reached & reached.T
    blocks: list[NDArray[np.int64]] = []
    seen = np.zeros(places.size, dtype=np.bool_)
    for number in range(places.size):
        if not seen[number]:
            seen |= together[number]
            blocks.append(places[together[number]])
    return sorted(blocks, key=lambda block: (-block.size, int(block[0])))


def _closure(linked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What is reached from where in any number of steps, none among them."""
    reached = linked | np.eye(linked.shape[0], dtype=np.bool_)
    while True:
        further = (reached.astype(np.float32) @ reached.astype(np.float32)) > 0.0
        if np.array_equal(further, reached):
            return reached
        reached = further
