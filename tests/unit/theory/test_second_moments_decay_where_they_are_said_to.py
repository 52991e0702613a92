"""The map of second moments by what its fates have in common, and the proof that it decays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.analysis.chance.chain import Chain, ChainStep
from cosim.analysis.chance.second_moments import SecondMoments
from cosim.theory.numerics import Real, spectral_radius


def drawn(seed: int, modes: int, outcomes: int, size: int, rank: int) -> tuple[Real, Chain]:
    """Maps that differ in a few numbers that they read, and a chain between modes."""
    rng = np.random.default_rng(seed)
    read = rng.normal(size=(rank, size))
    maps = rng.normal(size=(size, size)) + rng.normal(size=(outcomes, size, rank)) @ read
    chances = rng.dirichlet(np.ones(modes * outcomes), modes)
    steps = [
        ChainStep(i, j, float(chances[i, j * outcomes + e]), ())
        for i in range(modes)
        for j in range(modes)
        for e in range(outcomes)
    ]
    return maps, Chain(modes, tuple(steps))


def dense(maps: Real, chain: Chain, numbers: list[int]) -> Real:
    """Σ p M ⊗ M, mode by mode."""
    size = maps.shape[1] ** 2
    found = np.zeros((chain.modes * size, chain.modes * size))
    for step, number in zip(chain.steps, numbers, strict=True):
        rows = slice(step.target * size, (step.target + 1) * size)
        columns = slice(step.source * size, (step.source + 1) * size)
        found[rows, columns] += step.probability * np.kron(maps[number], maps[number])
    return found


CASES = st.tuples(
    st.integers(0, 2**32 - 1),
    st.integers(1, 3),
    st.integers(1, 4),
    st.integers(1, 4),
    st.integers(0, 2),
)


@given(CASES)
@settings(max_examples=40)
def test_the_map_is_the_sum_over_fates(case: tuple[int, int, int, int, int]) -> None:
    maps, chain = drawn(*case)
    numbers = [place % case[2] for place in range(len(chain.steps))]
    moments = SecondMoments(maps, chain, numbers)
    vector = np.random.default_rng(case[0] + 1).normal(size=moments.identity.size)
    symmetric = vector.reshape(chain.modes, maps.shape[1], -1)
    symmetric = (symmetric + symmetric.transpose(0, 2, 1)).reshape(-1)
    wanted = dense(maps, chain, numbers) @ symmetric
    assert moments.apply(symmetric) == pytest.approx(wanted, rel=1e-11, abs=1e-11)


@given(CASES, st.sampled_from([0.2, 0.9, 0.97, 0.999999, 1.0, 1.000001, 1.2]))
@settings(max_examples=40)
def test_decay_is_proved_where_there_is_decay(
    case: tuple[int, int, int, int, int], radius: float
) -> None:
    maps, chain = drawn(*case)
    numbers = [place % case[2] for place in range(len(chain.steps))]
    maps = maps * np.sqrt(radius / spectral_radius(dense(maps, chain, numbers)))
    proved = SecondMoments(maps, chain, numbers).surely_decay()
    if radius >= 1.0 - 1e-9:
        assert not proved
    if radius <= 0.9:
        assert proved
