"""Delay, offset, gain, payload and force are found within the tolerances, or their lack is said.

The tolerances come first. Each has an ablation beside it that breaks it.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.identification.regressor import INERTIAS, inertia_matrix
from cosim.identification.report import lines
from cosim.identification.results import Identified, identify
from tests.support.identification.known import (
    DEVICE,
    HAPLY,
    HOME,
    TICK,
    VALUES,
    changed,
    known,
)

INERTIA, COULOMB, GAIN = 0.02, 0.02, 0.02
LATENCY = 0.1 * TICK
OFFSET = 3e-3
HOME_INERTIA = inertia_matrix(HAPLY, HOME) @ VALUES[: len(INERTIAS)]


def found_in(*recordings, **choice) -> Identified:
    return identify(DEVICE, list(recordings), [1] * len(recordings), **choice)


def error(found: Identified, name: str, truth: float) -> float:
    value = found[name].value
    assert value is not None, found[name].reason
    return abs(value - truth)


@pytest.fixture(scope="module")
def pair():
    return [
        known(seed=1, offset=(0.01, -0.008), gain=(1.1, 0.9), delay=1.5),
        known(seed=2, offset=(0.01, -0.008), gain=(1.1, 0.9), delay=1.5, payload=0.05),
    ]


@pytest.fixture(scope="module")
def told(pair):
    return found_in(*pair)


def test_two_runs_with_a_known_mass_tell_everything_but_viscous_friction(told):
    for name, truth in (("home_11", (0, 0)), ("home_12", (0, 1)), ("home_22", (1, 1))):
        assert error(told, name, HOME_INERTIA[truth]) < INERTIA * HOME_INERTIA[0, 0]
    assert error(told, "coulomb_1", 0.004) < COULOMB * 0.004
    assert error(told, "latency", 1.5 * TICK) < LATENCY
    assert error(told, "offset_1", 0.01) < OFFSET
    assert error(told, "offset_2", -0.008) < OFFSET
    assert error(told, "gain_1", 1.1) < GAIN
    assert error(told, "gain_2", 0.9) < GAIN
    assert told.white.is_white


def test_a_wrong_mass_breaks_gain_and_inertia(pair):
    wrong = found_in(pair[0], changed(pair[1], payload=0.045))
    assert error(wrong, "gain_1", 1.1) > GAIN * 1.1
    assert error(wrong, "home_11", HOME_INERTIA[0, 0]) > INERTIA * HOME_INERTIA[0, 0]


def test_the_right_lengths_are_not_told_of(told):
    assert told.wrong_lengths == ()
    assert told.is_whole


def with_wrong(name: str, share: float) -> Identified:
    wrong = replace(DEVICE, bar=replace(HAPLY, **{name: share * getattr(HAPLY, name)}))
    return identify(wrong, [known(offset=(0.01, -0.008))], [1])


def test_a_distal_link_of_the_wrong_length_is_told_of():
    """Though its residual is white."""
    found = with_wrong("distal", 1.05)
    assert found.white.is_white
    assert found.wrong_lengths
    assert not found.is_whole
    assert any("geometry is NOT" in line for line in lines(found))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "share"), [("distal", 1.02), ("distal", 0.95), ("proximal", 0.95), ("base", 1.2)]
)
def test_a_wrong_length_is_never_silent(name, share):
    """It is refused, told of, or so small that the inertia at home is within its tolerance."""
    found = None
    with suppress(InputError):
        found = with_wrong(name, share)
    if found is not None and found.is_whole:
        assert error(found, "home_11", HOME_INERTIA[0, 0]) < INERTIA * HOME_INERTIA[0, 0]


def test_sides_that_differ_are_told_where_the_runs_are_asked():
    heavier = 20e-6
    run = known(heavier=heavier)
    apart = found_in(run, alike=False)
    for name, value in (("J_1", VALUES[0]), ("J_2", VALUES[1] + heavier)):
        assert apart[name].low <= value <= apart[name].high
    with pytest.raises(InputError, match="no delay, offset, gain and inertia explain"):
        found_in(run)


def test_friction_that_is_ignored_breaks_latency_and_whiteness(pair):
    wrong = found_in(*pair, friction=False)
    assert error(wrong, "latency", 1.5 * TICK) > LATENCY
    assert not wrong.white.is_white


def test_offsets_that_are_ignored_bias_the_inertia_of_the_tip(pair):
    right, wrong = found_in(*pair), found_in(*pair, offsets=False)
    assert abs(wrong.fit.values[3] - VALUES[3]) > 2 * abs(right.fit.values[3] - VALUES[3])


def test_a_force_sensor_tells_the_gain_as_well():
    run = known(gain=(1.2, 1.2), force=(1.0, 1.0))
    found = found_in(run)
    assert error(found, "gain_1", 1.2) < GAIN * 1.2
    with pytest.raises(InputError, match="was nobody holding it"):
        found_in(changed(run, force=None))


def test_without_mass_and_sensor_the_gain_is_not_told():
    found = found_in(known(gain=(1.1, 1.1)))
    assert found["gain_1"].value is None
    assert found["gain_1"].low is None
    assert "known mass" in found["gain_1"].reason


def test_viscous_friction_has_an_interval_that_holds_it_and_no_value(told):
    for name in ("viscous_1", "viscous_2"):
        each = told[name]
        assert each.value is None
        assert each.low is not None
        assert each.high is not None
        assert each.low < 1e-5 < each.high


def test_one_joint_alone_does_not_tell_both():
    run = known()
    still = run.angle.copy()
    still[:, 1] = HOME[1]
    with pytest.raises(InputError, match="hardly move"):
        found_in(changed(run, angle=still))


@pytest.mark.parametrize("seed", range(3))
def test_intervals_hold_the_truth(seed):
    found = found_in(known(seed=10 + seed, offset=(0.004, 0.0)))
    truth = dict(zip((each.name for each in INERTIAS), VALUES[:5], strict=True))
    truth |= {"home_11": HOME_INERTIA[0, 0], "coulomb_1": 0.004, "coulomb_2": 0.004}
    truth |= {"latency": TICK, "offset_1": 0.004, "offset_2": 0.0, "viscous_1": 1e-5}
    outside = [
        name
        for name, value in truth.items()
        if not (found[name].low or -np.inf) <= value <= (found[name].high or np.inf)
    ]
    assert len(outside) <= 1, outside
