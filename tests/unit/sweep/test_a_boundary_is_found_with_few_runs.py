"""The quadtree gives the verdict of the whole grid, each point asked once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.sweep.boundary import Place, crossed, refine

SHAPE = (41, 37)


def tongues(seed: int) -> np.ndarray:
    """A smooth region with holes: rows cross its boundary up to several times."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, SHAPE[0]), np.linspace(0, 1, SHAPE[1]), indexing="ij")
    level = sum(
        rng.normal() * np.sin(np.pi * (k + 1) * x + rng.uniform(0, 6)) * np.cos(np.pi * k * y)
        for k in range(4)
    )
    return level > 0


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000))
def test_with_the_theory_it_is_exact(seed: int) -> None:
    truth = tongues(seed)
    asked: list[Place] = []

    def evaluate(places: Sequence[Place]) -> dict[Place, bool]:
        asked.extend(places)
        return {place: bool(truth[place]) for place in places}

    found = refine(SHAPE, evaluate, lambda place: bool(truth[place]))
    assert found == {place: bool(truth[place]) for place in np.ndindex(SHAPE)}
    assert len(asked) == len(set(asked))


def test_a_line_takes_few_runs() -> None:
    asked: list[Place] = []

    def evaluate(places: Sequence[Place]) -> dict[Place, bool]:
        asked.extend(places)
        return {(i, j): i + 2 * j < 190 for i, j in places}

    found = refine((193, 193), evaluate, None)
    assert found == {(i, j): i + 2 * j < 190 for i, j in np.ndindex(193, 193)}
    assert len(asked) < 0.07 * 193 * 193


@pytest.mark.parametrize("shape", [(2, 2), (2, 40), (3, 17)])
def test_a_small_grid_is_run_whole_where_it_must(shape: tuple[int, int]) -> None:
    checks = {place: (place[0] + place[1]) % 2 == 0 for place in np.ndindex(shape)}
    found = refine(shape, lambda places: {p: checks[p] for p in places}, checks.__getitem__)
    assert found == checks


def test_what_a_boundary_crosses_has_a_neighbour_of_the_other_side() -> None:
    assert crossed((3, 3), lambda place: place[0] == 0) == {
        *((0, j) for j in range(3)),
        *((1, j) for j in range(3)),
    }
