"""Deadlines are absolute and exact; nothing is early, caught up, or lost from the statistics."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.errors import RunError
from hil.deadlines import Deadlines
from hil.pulse import RUNNING, Pulse
from hil.realtime import RealtimePacer, clock_nanosleep

TICK = Fraction(1, 1024)
PERIOD = 976562.5


class Clock:
    """A clock that moves when somebody sleeps, and oversleeps as told."""

    def __init__(self, oversleep=()):
        self.now = 1_000_000
        self.oversleep = list(oversleep)

    def read(self):
        self.now += 1
        return self.now

    def sleep(self, until):
        assert until >= self.now
        self.now = until + (self.oversleep.pop(0) if self.oversleep else 0)


def pacer(clock, **options):
    return RealtimePacer(tick_seconds=TICK, clock=clock.read, sleep=clock.sleep, **options)


def test_a_million_ticks_later_the_grid_has_not_drifted():
    clock = Clock()
    made = pacer(clock)
    made.start(0)
    origin = clock.now
    made.wait(1_024_000)
    assert 0 <= clock.now - (origin + 1_000_000_000_000) < 10


@settings(deadline=None)
@given(st.lists(st.integers(0, 5_000_000), min_size=1, max_size=50))
def test_never_early_never_two_ticks_in_one_period(oversleeps):
    clock = Clock(oversleeps)
    made = pacer(clock)
    made.start(0)
    origin, times = clock.now, []
    for tick in range(1, len(oversleeps) + 1):
        made.wait(tick)
        times.append(clock.now)
    for tick, at in enumerate(times, start=1):
        assert at >= origin + int(tick * PERIOD)
    late = [o for o in oversleeps if o >= PERIOD]
    assert made.deadlines.ticks == len(oversleeps)
    assert made.deadlines.misses >= len(late)
    assert made.deadlines.slipped >= sum(int(o // PERIOD) for o in late)
    assert sum(count for _, count in made.deadlines.histogram()) == len(oversleeps)


def test_the_policy_stop_says_which_tick():
    clock = Clock([0, 2_000_000])
    made = pacer(clock, policy="stop")
    made.start(0)
    made.wait(1)
    with pytest.raises(RunError, match="tick 2"):
        made.wait(2)


def test_every_wait_is_a_heartbeat():
    clock, pulse = Clock(), Pulse()
    made = pacer(clock, pulse=pulse)
    made.start(0)
    assert pulse.loop_state == RUNNING
    before = pulse.counter
    for tick in range(1, 6):
        made.wait(tick)
    assert pulse.counter == before + 5


def test_percentiles_are_the_sorted_list():
    deadlines = Deadlines()
    for micro in range(1000):
        deadlines.add(micro * 1000)
    assert deadlines.percentile(0.5) == pytest.approx(500e-6, abs=2e-6)
    assert deadlines.percentile(0.99) == pytest.approx(990e-6, abs=2e-6)
    deadlines.add(50_000_000)
    assert deadlines.percentile(1.0) == pytest.approx(0.05)
    assert deadlines.summary()["worst"] == pytest.approx(0.05)


def test_the_real_sleep_is_absolute_and_not_early():
    import time

    sleep = clock_nanosleep()
    for _ in range(5):
        until = time.monotonic_ns() + 2_000_000
        sleep(until)
        assert time.monotonic_ns() >= until
    sleep(0)
