"""Which points of the space are run: a grid, a Latin hypercube, or a Sobol sequence."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Sequence
from enum import StrEnum
from itertools import product
from typing import Any

from cosim.base.errors import InputError
from cosim.sweep.planning.axis import MOST, SweepAxis, Value

Point = tuple[Value, ...]
"""A value of each axis, in their order."""


class Sampling(StrEnum):
    """How points are chosen."""

    GRID = "grid"
    LATIN_HYPERCUBE = "latin_hypercube"
    SOBOL = "sobol"


def points_of(
    axes: Sequence[SweepAxis], sample: Sampling, count: int | None = None, seed: int = 0
) -> list[Point]:
    """Every point, in the order in which it is numbered.

    ``count`` and ``seed`` are of a Latin hypercube or a Sobol sequence, whose points are spread
    over the ranges; an axis that is a list is part of every point.

    Raises:
        InputError: a number of points where there is a grid, or none where there is not; too many.
    """
    lists = (len(each.values) for each in axes if each.span is None or sample is Sampling.GRID)
    whole = math.prod(lists) * (1 if sample is Sampling.GRID else count or 0)
    if whole > MOST:
        raise InputError(f"these are {whole} points; a sweep has at most {MOST}.")
    if sample is Sampling.GRID:
        if count is not None:
            raise InputError("a grid has the points of its axes; leave 'points' out.")
        return list(product(*(axis.values for axis in axes)))
    if count is None or count < 1:
        raise InputError(f"{sample}: say how many points there are.")
    free = [number for number, axis in enumerate(axes) if axis.span is not None]
    if not free:
        raise InputError(f"{sample} needs at least one axis that is a range, such as 0..1/10.")
    listed = [axis.values for axis in axes if axis.span is None]
    return [
        _joined(axes, shares, rest)
        for rest in product(*listed)
        for shares in _shares(sample, len(free), count, seed)
    ]


def _joined(axes: Sequence[SweepAxis], shares: Sequence[float], rest: Sequence[Value]) -> Point:
    of_range: Iterator[float] = iter(shares)
    of_list: Iterator[Value] = iter(rest)
    return tuple(
        next(of_list) if axis.span is None else axis.span.at(next(of_range)) for axis in axes
    )


def _shares(sample: Sampling, dimensions: int, count: int, seed: int) -> list[list[float]]:
    qmc: Any = importlib.import_module("scipy.stats").qmc  # half a second to import
    if sample is Sampling.LATIN_HYPERCUBE:
        return qmc.LatinHypercube(dimensions, rng=seed).random(count).tolist()
    if count & (count - 1):
        raise InputError(
            f"a Sobol sequence is even only for a power of 2: {count} points; take "
            f"{1 << (count.bit_length() - 1)} or {1 << count.bit_length()}."
        )
    return qmc.Sobol(dimensions, rng=seed).random(count).tolist()
