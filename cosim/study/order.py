"""In which order participants meet the conditions, so that neither is taken for the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def williams_square(count: int) -> list[list[int]]:
    """Rows in which each condition stands at each place, and follows each other one, equally often.

    Williams 1949: ``count`` rows for an even number of conditions, twice as many for an odd one.
    """
    first = [0]
    for step in range(1, count):
        first.append((first[-1] + (step if step % 2 else -step)) % count)
    rows = [[(each + shift) % count for each in first] for shift in range(count)]
    return rows + [row[::-1] for row in rows] if count % 2 and count > 1 else rows


def blocked(conditions: Sequence[str], trials: int, number: int) -> list[str]:
    """The condition of every trial of the participant with this number, one block a condition."""
    rows = williams_square(len(conditions))
    row = rows[number % len(rows)]
    return [conditions[each] for each in row for _ in range(trials)]


def interleaved(conditions: Sequence[str], trials: int, number: int, seed: int) -> list[str]:
    """All conditions in each round, each round in an order of its own."""
    generator = np.random.Generator(np.random.PCG64([seed, number]))
    rounds = (generator.permutation(len(conditions)) for _ in range(trials))
    return [conditions[int(each)] for order in rounds for each in order]
