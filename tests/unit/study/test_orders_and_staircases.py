"""Orders are balanced, staircases converge where they should, thresholds lie in their intervals."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.study.form import StaircaseForm
from cosim.study.order import blocked, interleaved, williams_square
from cosim.study.staircase import next_value
from cosim.study.threshold import estimate


@pytest.mark.parametrize("count", range(1, 10))
def test_each_condition_stands_everywhere_and_follows_every_other_equally_often(count: int) -> None:
    rows = williams_square(count)
    assert all(sorted(row) == list(range(count)) for row in rows)
    for place in range(count):
        assert set(Counter(row[place] for row in rows).values()) == {len(rows) // count}
    follows = Counter(pair for row in rows for pair in pairwise(row))
    if count > 1:
        assert len(follows) == count * (count - 1)
        assert len(set(follows.values())) == 1


@given(st.integers(1, 5), st.integers(1, 6), st.integers(0, 40), st.integers(0, 2**40))
def test_everybody_meets_every_condition_as_often(
    count: int, trials: int, number: int, seed: int
) -> None:
    names = [f"c{each}" for each in range(count)]
    for order in (blocked(names, trials, number), interleaved(names, trials, number, seed)):
        assert Counter(order) == dict.fromkeys(names, trials)
    mixed = interleaved(names, trials, number, seed)
    assert mixed == interleaved(names, trials, number, seed)
    assert all(
        set(mixed[first : first + count]) == set(names) for first in range(0, len(mixed), count)
    )


def rule(**changed: object) -> StaircaseForm:
    plain = {"vary": "x", "least": 0.0, "most": 16.0, "start": 8.0, "steps": [1.0], "answer": "a"}
    return StaircaseForm(**{**plain, **changed})


def logistic(value: float, threshold: float, slope: float) -> float:
    return 1 / (1 + math.exp(-slope * (value - threshold)))


@given(st.lists(st.booleans(), max_size=60), st.integers(1, 4), st.integers(1, 4))
def test_it_stays_within_its_bounds(answers: list[bool], down: int, up: int) -> None:
    form = rule(steps=[4.0, 3.0, 0.7], down=down, up=up)
    past: list[tuple[float, bool]] = []
    for noticed in answers:
        value = next_value(form, past)
        assert form.least <= value <= form.most
        assert not past or abs(value - past[-1][0]) <= 4.0
        past.append((value, noticed))


@pytest.mark.parametrize(("down", "up", "share"), [(1, 1, 0.5), (2, 1, 0.5**0.5), (3, 1, 0.7937)])
def test_it_converges_to_its_share(down: int, up: int, share: float) -> None:
    """Levitt 1971, table I."""
    form = rule(down=down, up=up, steps=[0.25])
    generator = np.random.default_rng(3)
    past: list[tuple[float, bool]] = []
    for _ in range(600):
        value = next_value(form, past)
        past.append((value, bool(generator.random() < logistic(value, 6.0, 1.0))))
    mean = np.mean([value for value, _ in past[100:]])
    assert logistic(float(mean), 6.0, 1.0) == pytest.approx(share, abs=0.06)


def test_the_interval_holds_the_threshold_as_often_as_it_says() -> None:
    form = rule(steps=[4.0, 2.0, 1.0])
    generator = np.random.default_rng(11)
    held, studies = 0, 120
    for _ in range(studies):
        threshold, slope = generator.uniform(3, 12), generator.uniform(0.5, 3)
        past: list[tuple[float, bool]] = []
        for _ in range(24):
            value = next_value(form, past)
            past.append((value, bool(generator.random() < logistic(value, threshold, slope))))
        found = estimate(past, form.least, form.most)
        assert found.low <= found.value <= found.high
        held += found.low <= threshold <= found.high
    assert held / studies > 0.9


def test_answers_the_other_way_round_say_something_else() -> None:
    past = [(value, value > 4) for value in np.linspace(0, 16, 24)]
    assert estimate(past, 0, 16).high < 6
    wrong = [(value, not noticed) for value, noticed in past]
    assert estimate(wrong, 0, 16).value > 8
