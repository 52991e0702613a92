"""Where good turns into failed on a grid of two axes, with few of its points run.

A quadtree: a rectangle of grid points is split while its corners do not agree, or while the theory
sees its own boundary within it. Along a row the verdict may turn several times, which is why
nothing is bisected.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise

Place = tuple[int, int]
"""A point of the grid: its index on the first and on the second axis."""

COARSE = 8
"""Grid steps from corner to corner of the first rectangles."""
_Box = tuple[int, int, int, int]


def refine(
    shape: tuple[int, int],
    evaluate: Callable[[Sequence[Place]], Mapping[Place, bool]],
    theory: Callable[[Place], bool] | None = None,
    coarse: int = COARSE,
) -> dict[Place, bool]:
    """The verdict of each point of a grid.

    ``evaluate`` runs points, which it is given in rounds, each point once. ``theory`` says what the
    verdict should be. Points within a rectangle whose corners agree have its corners' verdict.
    """
    known: dict[Place, bool] = {}
    boxes = deque(_first(shape, coarse))
    uniform: list[_Box] = []
    while boxes:
        wanted = {corner for box in boxes for corner in _corners(box)} - set(known)
        known |= evaluate(sorted(wanted))
        split: deque[_Box] = deque()
        for box in boxes:
            is_mixed = len({known[corner] for corner in _corners(box)}) > 1
            if not (is_mixed or _sees(theory, box)):
                uniform.append(box)
            elif box[1] - box[0] > 1 or box[3] - box[2] > 1:
                split.extend(_split(box))
        boxes = split
    found = dict(known)
    for box in uniform:
        verdict = known[box[0], box[2]]
        for place in _inside(box):
            found.setdefault(place, verdict)
    return found


def crossed(shape: tuple[int, int], verdict: Callable[[Place], bool]) -> set[Place]:
    """The points with a neighbour, also across a corner, of another verdict."""
    found: set[Place] = set()
    for place in _inside((0, shape[0] - 1, 0, shape[1] - 1)):
        if any(verdict(other) != verdict(place) for other in neighbours(place, shape)):
            found.add(place)
    return found


def neighbours(place: Place, shape: tuple[int, int]) -> list[Place]:
    """The up to eight points around a point."""
    return [
        (i, j)
        for i in range(place[0] - 1, place[0] + 2)
        for j in range(place[1] - 1, place[1] + 2)
        if (i, j) != place and 0 <= i < shape[0] and 0 <= j < shape[1]
    ]


def _first(shape: tuple[int, int], coarse: int) -> Iterable[_Box]:
    lines = [sorted({*range(0, count, coarse), count - 1}) for count in shape]
    for left, right in pairwise(lines[0]):
        for low, high in pairwise(lines[1]):
            yield left, right, low, high


def _split(box: _Box) -> Iterable[_Box]:
    left, right, low, high = box
    across = [left, (left + right) // 2, right] if right - left > 1 else [left, right]
    up = [low, (low + high) // 2, high] if high - low > 1 else [low, high]
    for a, b in pairwise(across):
        for c, d in pairwise(up):
            yield a, b, c, d


def _corners(box: _Box) -> list[Place]:
    left, right, low, high = box
    return [(left, low), (left, high), (right, low), (right, high)]


def _inside(box: _Box) -> Iterable[Place]:
    for i in range(box[0], box[1] + 1):
        for j in range(box[2], box[3] + 1):
            yield i, j


def _sees(theory: Callable[[Place], bool] | None, box: _Box) -> bool:
    return theory is not None and len({theory(place) for place in _inside(box)}) > 1
