"""Times of the safety layer are in ms at every rate, and what faded comes back slowly."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.device.contract import Flag, State
from hil.device.errors import Cause
from hil.safety.layer import SafetyLayer
from hil.safety.limits import BORDER_METRES, LATE_SECONDS, LEAST_TICKS, Limits, TickLimits
from hil.safety.linkage import Region
from tests.support.hil.hil_bench import QUANSER, REST, REST_ANGLE, Puppet, mock, rested, run

COMMAND = (0.01, 0.0)


def ramped(rate: float, region: Region | None = None) -> tuple[SafetyLayer, int]:
    """A layer whose force is all there, and the next tick."""
    layer = SafetyLayer(Limits(slew=1e4), QUANSER, tick=1 / rate, quantum=1e-4, region=region)
    ticks = math.ceil(2.0 * rate)
    for tick in range(ticks):
        assert layer.observe(tick, REST_ANGLE, 0) is None
        layer.limit(tick, COMMAND if tick else (0.0, 0.0))
    return layer, ticks


@given(st.floats(LEAST_TICKS / LATE_SECONDS, 20_000.0))
def test_limits_in_ms_are_whole_ticks_rounded_down_at_every_rate(rate):
    found = TickLimits.at(1 / rate)
    for ticks, seconds in ((found.hold, 0.002), (found.drop, 0.010)):
        assert ticks / rate <= seconds * (1 + 1e-6) < (ticks + 1) / rate
    assert found.hold < found.drop


def test_at_1024_hz_they_are_what_the_page_says():
    assert TickLimits.at(1 / 1024) == TickLimits(hold=2, drop=10, speed_window=32, vibration=8)


@pytest.mark.parametrize(("rate", "held", "dropped"), [(500, 1, 5), (1024, 2, 10), (4096, 8, 40)])
def test_a_torque_is_dropped_within_10_ms_at_every_rate(rate, held, dropped):
    layer, tick = ramped(rate)
    for age in range(1, dropped):
        assert layer.observe(tick, REST_ANGLE, age) is None
        torque = layer.limit(tick, COMMAND).torque[0]
        assert torque == COMMAND[0] if age <= held else 0.0 < torque < COMMAND[0]
        tick += 1
    trip = layer.observe(tick, REST_ANGLE, dropped)
    assert trip is not None
    assert trip.cause is Cause.STALE


@pytest.mark.parametrize("age", [3, 6, 9])
def test_after_a_gap_force_comes_back_through_the_ramp(age):
    layer, tick = ramped(1024)
    for old in range(1, age + 1):
        layer.observe(tick, REST_ANGLE, old)
        lowest = layer.limit(tick, COMMAND).torque[0]
        tick += 1
    assert lowest == pytest.approx(COMMAND[0] * (10 - age) / 8)
    sent = [lowest]
    for _ in range(1600):
        layer.observe(tick, REST_ANGLE, 0)
        sent.append(layer.limit(tick, COMMAND).torque[0])
        tick += 1
    step = COMMAND[0] / (Limits().ramp_time * 1024)
    assert all(now - before <= step * (1 + 1e-9) for before, now in pairwise(sent))
    assert sent[-1] == COMMAND[0]


NARROW = Region(left=0.02, right=0.065, bottom=0.18, top=0.215)


def walk(layer: SafetyLayer, tick: int, heights: list[float]) -> list[tuple[float, float, Flag]]:
    found = []
    for number, height in enumerate(heights):
        assert layer.observe(tick + number, QUANSER.angles((REST[0], height)), 0) is None
        decision = layer.limit(tick + number, COMMAND)
        found.append((height, decision.torque[0], decision.flags))
    return found


def test_force_fades_towards_the_border():
    layer, tick = ramped(1024, NARROW)
    heights = [REST[1] + step * 0.0002 for step in range(100)]
    for height, torque, flags in walk(layer, tick, heights):
        share = (NARROW.top - height) / BORDER_METRES
        assert torque == pytest.approx(COMMAND[0] * min(1.0, max(0.0, share)), abs=1e-9)
        if share < 1.0 - 1e-9:
            assert flags & (Flag.OUTSIDE_WORKSPACE if share <= 0.0 else Flag.NEAR_BORDER)


def test_a_tip_that_trembles_at_the_border_is_not_pushed_to_and_fro():
    layer, tick = ramped(1024, NARROW)
    out = [REST[1] + step * 0.0002 for step in range(80)]
    walk(layer, tick, out)
    tremble = [NARROW.top + 0.0015 * math.sin(step / 10) for step in range(400)]
    assert all(torque == 0.0 for _, torque, _ in walk(layer, tick + len(out), tremble))
    back = [NARROW.top - step * 0.0002 for step in range(80)]
    seen = walk(layer, tick + len(out) + len(tremble), back)
    first = next(height for height, torque, _ in seen if torque > 0.0)
    assert NARROW.top - first >= 0.0019
    assert max(torque for _, torque, _ in seen) < 0.1 * COMMAND[0], "through the ramp"


@pytest.mark.parametrize("fault", ["no number", "jump"])
def test_after_a_fault_and_a_reset_force_comes_back_through_the_ramp(fault: str):
    puppet = Puppet()
    device = rested(mock(puppet))
    device.activate()
    run(device, 600, COMMAND)
    assert device.sent[0] > 0.0
    if fault == "jump":
        puppet.put((REST[0] + 0.03, REST[1]))
    run(device, 40, (math.nan, 0.0) if fault == "no number" else COMMAND, start=600)
    assert device.state is State.FAULT
    device.reset()
    device.driver.body = Puppet()
    rested(device).activate()
    sent = [told.torque[0] for _, told in run(device, 2200, COMMAND)]
    step = COMMAND[0] / (Limits().ramp_time * 1024)
    assert all(now - before <= step + 2e-9 for before, now in pairwise([0.0, *sent]))
    assert sent[-1] == pytest.approx(COMMAND[0], abs=2e-9)
