"""Where a run beyond a factor has no answer, its margins say up to where they have one, and why."""

from __future__ import annotations

import math

import pytest

from cosim.analysis.answers.run_margins import FURTHEST_FACTOR, NOT_LOOKED, _around_one
from cosim.base.errors import InputError


def refused_beyond(edge: float, unstable: float = math.inf):
    """A radius that grows to 1 at a factor, and has no answer beyond another."""

    def radius(factor: float) -> float:
        if factor > edge:
            raise InputError("A current saturates.")
        return 0.9 * (factor / unstable) ** 0.1 if unstable < math.inf else 0.9

    return radius


@pytest.mark.parametrize("edge", [1.2, 1.917, 5.0])
def test_the_answer_ends_where_the_run_has_none(edge: float) -> None:
    found = _around_one(refused_beyond(edge), linear=False)
    assert edge / 1.01 < found.high <= edge
    assert found.above == "A current saturates."
    assert found.low == pytest.approx(1 / FURTHEST_FACTOR)
    assert found.below == NOT_LOOKED


def test_an_instability_before_it_is_the_end() -> None:
    unstable = 3.0 * 0.9**10
    found = _around_one(refused_beyond(6.0, unstable), linear=False)
    assert found.high == pytest.approx(3.0, rel=1e-6)
    assert not found.above


def test_no_answer_but_for_the_run_itself() -> None:
    def radius(factor: float) -> float:
        if factor != 1.0:
            raise InputError("Nothing rests.")
        return 0.9

    found = _around_one(radius, linear=False)
    assert found.low == found.high == 1.0
    assert found.above == "Nothing rests."
