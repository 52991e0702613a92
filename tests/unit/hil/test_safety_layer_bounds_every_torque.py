"""Whatever is commanded and measured, the safety layer's rules hold at every tick."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.device.contract import Flag
from hil.device.errors import Cause
from hil.safety.layer import SafetyLayer
from hil.safety.limits import Limits, TickLimits
from hil.safety.linkage import Linkage, Region
from tests.support.hil.hil_bench import QUANSER, REST, REST_ANGLE

T = 1 / 1024
LIMITS = Limits()
WINDOW = TickLimits.at(T).speed_window


def layer(limits: Limits = LIMITS) -> SafetyLayer:
    made = SafetyLayer(limits, QUANSER, tick=T, quantum=2 * math.pi / 20000)
    for tick in range(WINDOW + 2):
        assert made.observe(tick, REST_ANGLE, 0) is None
    made.start()
    return made


def ramped(limits: Limits = LIMITS) -> SafetyLayer:
    made = layer(limits)
    for tick in range(2100):
        made.limit(tick, (0.0, 0.0))
    return made


anything = st.floats(allow_nan=True, allow_infinity=True)
torques = st.floats(-1.0, 1.0)


@settings(deadline=None)
@given(st.lists(st.tuples(anything, anything), min_size=1, max_size=60))
def test_no_command_gets_past_the_torque_limit_or_comes_back_as_no_number(commands):
    safe = ramped()
    for tick, command in enumerate(commands):
        decision = safe.limit(tick, command)
        assert all(abs(torque) <= LIMITS.torque for torque in decision.torque)
        if not all(math.isfinite(value) for value in command):
            assert decision.torque == (0.0, 0.0)
            assert decision.trip is not None
            assert decision.trip.cause is Cause.COMMAND


@settings(deadline=None)
@given(st.lists(st.tuples(torques, torques), min_size=2, max_size=80))
def test_slew_bounds_an_increase_and_never_delays_a_reduction(commands):
    safe = ramped()
    sent = [(0.0, 0.0)]
    for tick, command in enumerate(commands):
        sent.append(safe.limit(tick, command).torque)
    step = LIMITS.slew * T
    for wanted, (before, now) in zip(commands, pairwise(sent), strict=True):
        for axis in (0, 1):
            carried = abs(before[axis]) if before[axis] * now[axis] > 0 else 0.0
            assert abs(now[axis]) <= carried + step + 1e-15
            target = min(abs(wanted[axis]), LIMITS.torque)
            if wanted[axis] * before[axis] >= 0 and target <= abs(before[axis]):
                assert abs(now[axis]) == pytest.approx(target, abs=1e-15)
            assert abs(now[axis]) <= abs(wanted[axis])
            assert now[axis] * wanted[axis] >= 0


@settings(deadline=None)
@given(st.integers(0, 40), torques)
def test_age_holds_then_ramps_then_drops(age, torque):
    safe = ramped(Limits(slew=1e6 * T))
    command = (torque * 0.1, 0.0)
    fresh = safe.limit(0, command).torque
    trip = safe.observe(1000, REST_ANGLE, age)
    decision = safe.limit(1, command)
    if age <= 2:
        assert decision.torque == fresh
    elif age <= 9:
        assert decision.torque[0] == pytest.approx(fresh[0] * (10 - age) / 8)
        assert decision.flags & Flag.AGED
    else:
        assert decision.torque == (0.0, 0.0)
        assert trip is not None
        assert trip.cause is Cause.STALE
        assert decision.trip is not None


def test_motor_heat_brings_the_torque_down_to_what_may_be_held_for_ever():
    safe = ramped()
    ticks = int(10 * LIMITS.peak_time / T)
    sent = [safe.limit(tick, (0.15, 0.0)).torque[0] for tick in range(ticks)]
    assert sent[int(0.2 / T)] == LIMITS.torque
    assert sent[-1] < LIMITS.continuous_torque * 1.02
    largest_drop = max(a - b for a, b in pairwise(sent))
    assert largest_drop < 0.002 * LIMITS.torque, "the hand must not feel a step"
    over = sum((torque**2 - LIMITS.continuous_torque**2) * T for torque in sent)
    budget = (LIMITS.torque**2 - LIMITS.continuous_torque**2) * LIMITS.peak_time
    assert over <= budget * (1 + 1e-9)


def test_force_comes_up_over_the_ramp_time():
    safe = layer(Limits(slew=1e4))
    sent = [safe.limit(tick, (0.01, 0.0)).torque[0] for tick in range(1600)]
    full = round(LIMITS.ramp_time / T)
    assert sent[0] == pytest.approx(0.01 / full)
    assert sent[full // 2 - 1] == pytest.approx(0.005, rel=1e-2)
    assert sent[full] == 0.01


@pytest.mark.parametrize(("share", "refused"), [(0.09, False), (0.1, True), (0.5, True)])
def test_the_first_command_has_to_be_small(share, refused):
    decision = layer().limit(0, (0.0, -share * LIMITS.torque))
    assert (decision.trip is not None) is refused
    if refused:
        assert decision.trip.cause is Cause.FIRST_COMMAND
        assert decision.torque == (0.0, 0.0)


def test_a_jump_of_counts_trips_in_the_tick_in_which_it_is_seen():
    safe = ramped()
    quantum = 2 * math.pi / 20000
    allowed = LIMITS.joint_speed * T + 2 * quantum
    base = WINDOW + 2
    assert safe.observe(base, (REST_ANGLE[0] + allowed * 0.99, REST_ANGLE[1]), 0) is None
    trip = safe.observe(base + 1, (REST_ANGLE[0] - allowed * 0.02, REST_ANGLE[1]), 0)
    assert trip is not None
    assert trip.cause is Cause.JUMP
    assert trip.cause.unhomes


def test_a_fast_tip_fades_the_torque_and_then_trips():
    slow = Limits(tip_speed=0.3)
    safe = ramped(slow)
    tick, x, speed, trip, shares = WINDOW + 2, REST[0], 0.0, None, []
    while trip is None:
        speed += 2.0 * T
        x += speed * T
        trip = safe.observe(tick, QUANSER.angles((x, REST[1])), 0)
        shares.append(safe.limit(tick, (0.05, 0.0)).torque[0] / 0.05)
        tick += 1
        assert tick < 400
    assert trip.cause is Cause.SPEED
    assert speed < 0.3 + 2.0 * T * WINDOW
    assert min(shares[:100]) > 0.99
    assert shares[-1] < 0.1


def test_outside_the_workspace_nothing_is_sent_and_no_fault_is_made():
    safe = ramped()
    tick = WINDOW + 2
    for step in range(400):
        y = REST[1] + step * 0.0002
        angles = QUANSER.angles((REST[0], y))
        if angles is None:
            break
        assert safe.observe(tick + step, angles, 0) is None
        decision = safe.limit(tick + step, (0.01, 0.01))
        if not safe.inside:
            assert decision.torque == (0.0, 0.0)
            assert decision.flags & Flag.OUTSIDE_WORKSPACE
            return
    pytest.fail("the tip never left the workspace")


def test_angles_at_which_the_links_cannot_meet_are_no_measurement():
    wide = Linkage(proximal=0.1, distal=0.12, base=0.085)
    fresh = SafetyLayer(LIMITS, wide, tick=T, quantum=1e-4)
    trip = fresh.observe(0, (math.pi, 0.0), 0)
    assert trip is not None
    assert trip.cause is Cause.MEASUREMENT
    trip = fresh.observe(1, (math.nan, 0.0), 0)
    assert trip is not None
    assert trip.cause is Cause.MEASUREMENT


@pytest.mark.parametrize("frequency", [10.0, 20.0, 40.0])
def test_a_tip_that_vibrates_faster_than_the_limit_trips(frequency):
    """A long chord alone is nearly zero where it is a whole period."""
    peak = 1.4 * LIMITS.tip_speed
    amplitude = peak / (2 * math.pi * frequency)
    safe, trip = ramped(), None
    for tick in range(WINDOW + 2, WINDOW + 400):
        grown = min(1.0, tick / 200)
        x = REST[0] + grown * amplitude * math.sin(2 * math.pi * frequency * tick * T)
        trip = trip or safe.observe(tick, QUANSER.angles((x, REST[1])), 0)
    assert trip is not None
    assert trip.cause is Cause.SPEED


def test_force_comes_back_into_the_workspace_through_the_ramp():
    narrow = Region(left=0.02, right=0.06, bottom=0.19, top=0.21)
    safe = SafetyLayer(LIMITS, QUANSER, tick=T, quantum=1e-4, region=narrow)
    tick, command, sent = 0, (0.01, 0.0), []

    def at(y: float, ticks: int) -> None:
        nonlocal tick
        for _ in range(ticks):
            assert safe.observe(tick, QUANSER.angles((REST[0], y)), 0) is None
            sent.append(safe.limit(tick, command).torque[0])
            tick += 1

    at(REST[1], 40)
    safe.start()
    at(REST[1], 2000)
    assert sent[-1] == command[0]
    for step in range(60):
        at(REST[1] + step * 0.0002, 1)
    assert sent[-1] == 0.0
    for step in range(60):
        at(REST[1] + (60 - step) * 0.0002, 1)
    at(REST[1], 200)
    assert 0.0 < sent[-1] < 0.3 * command[0], "no step at the border"
