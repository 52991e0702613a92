"""A row counts where its sample is new, the output on and no joint at its limit; the rest is told.

Too little of it, or too little motion in it, is a sentence and no number.
"""

from __future__ import annotations

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.identification.report import lines
from cosim.identification.results import identify
from tests.support.identification.known import DEVICE, changed, known


def told(*recordings, steps=None):
    return identify(DEVICE, list(recordings), steps or [1] * len(recordings))


@pytest.fixture(scope="module")
def run():
    return known()


def test_too_short_a_run_is_refused(run):
    short = {name: getattr(run, name)[:8000] for name in ("ticks", "angle", "torque", "age")}
    with pytest.raises(InputError, match=r"7\.8 s of these runs can be used, 10 s are needed"):
        told(changed(run, **short, status=run.status[:8000]))


def test_a_dry_run_is_refused(run):
    with pytest.raises(InputError, match=r"0\.0 s of these runs"):
        told(changed(run, status=np.full(len(run.ticks), 3)))


def test_a_handle_at_rest_is_refused(run):
    with pytest.raises(InputError, match="hardly move"):
        told(changed(run, angle=np.zeros_like(run.angle) + run.angle[0]))


def test_what_no_five_bar_of_this_size_can_do_is_refused(run):
    with pytest.raises(InputError, match="geometry"):
        told(changed(run, torque=-run.torque[:, ::-1]))


def test_saturated_rows_are_left_out_and_counted(run):
    limit = 0.9 * np.abs(run.torque).max()
    found = told(changed(run, limit=limit))
    counted = int(np.sum(np.any(np.abs(run.torque) >= 0.995 * limit, axis=1)))
    assert found.counts.saturated == counted > 0
    assert found.counts.used < found.counts.rows


def test_held_samples_and_a_clock_with_gaps_are_left_out_and_counted(run):
    age, ticks = run.age.copy(), run.ticks.copy()
    age[7000:7003] = (1, 2, 3)
    angle = run.angle.copy()
    angle[7000:7003] += 0.05  # what was held would be seen
    ticks[9000:] += 5
    found = told(changed(run, age=age, ticks=ticks, angle=angle))
    assert (found.counts.stale, found.counts.gaps) == (3, 1)
    whole = told(run)
    value, right = found["home_11"].value, whole["home_11"].value
    assert value == pytest.approx(right, rel=0.005)
    # The same rows taken for new ones spoil it.
    spoiled = told(changed(run, angle=angle))
    assert abs(spoiled["home_11"].value - right) > abs(value - right)


def test_a_gap_in_the_clock_is_no_motion(run):
    ticks = run.ticks * 2
    assert told(changed(run, ticks=ticks), steps=[2]).counts.gaps == 0
    with pytest.raises(InputError, match="can be used"):
        told(changed(run, ticks=ticks), steps=[1])


def test_an_interval_without_a_value_has_its_unit(run):
    rows = [row for row in lines(told(run)) if row.startswith("viscous_")]
    assert len(rows) == 2
    assert all("–" in row and "uN.m.s/rad" in row for row in rows)
