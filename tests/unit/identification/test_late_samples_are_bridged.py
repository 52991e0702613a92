"""A device on a clock of its own misses a tick now and then: its run is no less worth for that."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.identification.regressor import inertia_matrix
from cosim.identification.results import Identified, identify
from cosim.identification.samples import BRIDGED, Recording
from tests.support.identification.known import DEVICE, HAPLY, HOME, VALUES, changed, known

EVERY = 25


def with_late_samples(ticks: int) -> Recording:
    """A run in which every so many rows the last angle is held for some ticks."""
    run = known(seconds=12.0)
    age, angle = run.age.copy(), run.angle.copy()
    for first in range(EVERY, len(age) - ticks, EVERY):
        for late in range(ticks):
            age[first + late], angle[first + late] = late + 1, angle[first - 1]
    return changed(run, age=age, angle=angle)


def found_in(run: Recording) -> Identified:
    return identify(DEVICE, [run], [1])


@pytest.mark.parametrize("ticks", range(1, BRIDGED + 1))
def test_samples_that_are_a_little_late_cost_nothing(ticks: int) -> None:
    run = with_late_samples(ticks)
    found = found_in(run)
    home = (inertia_matrix(HAPLY, HOME) @ VALUES[:5])[0, 0]
    assert found["home_11"].value == pytest.approx(home, rel=0.01)
    assert found["latency"].value * 1024 == pytest.approx(1.0, abs=0.05)
    assert found.counts.used > 0.99 * found.counts.rows
    assert found.counts.stale == int(np.sum(run.age > 0)), "they are told of all the same"


def test_held_angles_taken_for_measured_ones_would_be_wrong() -> None:
    run = with_late_samples(BRIDGED)
    held = found_in(changed(run, age=np.zeros_like(run.age)))
    assert abs(held["latency"].value * 1024 - 1.0) > 0.05


def test_later_samples_part_the_run() -> None:
    with pytest.raises(InputError, match=r"^0\.0 s of these runs can be used"):
        found_in(with_late_samples(BRIDGED + 1))


def test_what_lies_between_is_on_the_line_and_nothing_else_changes() -> None:
    run = known(seconds=2.0)
    age = run.age.copy()
    age[:3], age[100], age[200:202], age[300:303] = 1, 1, (1, 2), (1, 2, 3)
    force = np.stack([np.arange(len(age)), -np.arange(len(age))], axis=1).astype(float)
    held = force.copy()
    held[100] = held[99]
    run = changed(run, age=age, force=held, force_age=np.zeros_like(age))
    bridged = run.bridged()
    assert np.flatnonzero(bridged.age).tolist() == [0, 1, 2, 300, 301, 302]
    assert bridged.angle[100] == pytest.approx((run.angle[99] + run.angle[101]) / 2)
    assert bridged.angle[200] == pytest.approx((2 * run.angle[199] + run.angle[202]) / 3)
    assert bridged.force[100] == pytest.approx(force[100])
    others = np.setdiff1d(np.arange(len(age)), [100, 200, 201])
    assert np.array_equal(bridged.angle[others], run.angle[others])
