"""Deadlines are absolute and exact; nothing is early, run in a burst, or lost from the figures."""

from __future__ import annotations

import itertools
import time
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import RunError
from cosim.realtime.deadlines import Deadlines, MissCause
from cosim.realtime.pacing import DeadlinePacer, sleep_until

TICK = Fraction(1, 1024)
PERIOD = 976562.5


class World:
    """A clock that moves when somebody sleeps, oversleeps as told, or works."""

    def __init__(self, oversleep=()):
        self.now = 1_000_000
        self.worked = 0
        self.oversleep = list(oversleep)

    def read(self):
        self.now += 1
        return self.now

    def sleep(self, until):
        assert until >= self.now
        self.now = until + (self.oversleep.pop(0) if self.oversleep else 0)

    def work(self, spent, *, interrupted=0):
        self.now += spent + interrupted
        self.worked += spent

    def pacer(self, **options):
        made = DeadlinePacer(
            tick_seconds=options.pop("tick_seconds", TICK),
            clock=self.read,
            sleep=self.sleep,
            busy=lambda: self.worked,
            **options,
        )
        made.start(0)
        return made


def begun(world, pacer, works):
    """When each tick began (ns), each followed by some work."""
    times = []
    for tick, spent in enumerate(works):
        pacer.wait(tick)
        times.append(world.now)
        world.work(spent)
    return times


def test_a_million_ticks_later_the_grid_has_not_drifted():
    world = World()
    pacer = world.pacer()
    origin = world.now
    pacer.wait(1_024_000)
    assert 0 <= world.now - (origin + 1_000_000_000_000) < 10


@settings(deadline=None)
@given(st.lists(st.integers(0, 5_000_000), min_size=1, max_size=50))
def test_without_catching_up_no_tick_is_early_and_none_is_lost_from_the_figures(oversleeps):
    world = World()
    pacer = world.pacer()
    origin = world.now
    world.oversleep = list(oversleeps)
    times = begun(world, pacer, [0] * (len(oversleeps) + 1))
    for tick, at in enumerate(times):
        assert at >= origin + int(tick * PERIOD)
    found = pacer.deadlines
    assert found.ticks == len(oversleeps) + 1
    assert found.misses >= sum(o >= PERIOD for o in oversleeps)
    assert found.slipped >= sum(int(o // PERIOD) for o in oversleeps)
    assert found.off_grid == found.caught_up == 0
    assert sum(found.causes.values()) == found.misses
    assert sum(count for _, count in found.histogram()) == found.ticks


@settings(deadline=None)
@given(
    st.lists(st.integers(0, 20_000_000), min_size=1, max_size=4),
    st.sampled_from([0.1, 0.25, 0.4]),
)
def test_what_catches_up_keeps_its_distance_and_comes_back_to_the_grid(oversleeps, share):
    world = World(oversleeps)
    pacer = world.pacer(catch_up=share)
    origin = world.now
    ticks = len(oversleeps) + 1 + int(sum(oversleeps) / (share * PERIOD)) + 2
    times = begun(world, pacer, [0] * ticks)
    steps = [after - before for before, after in itertools.pairwise(times)]
    assert min(steps) >= (1 - share) * PERIOD - 2
    assert abs(times[-1] - (origin + int((ticks - 1) * PERIOD))) < 10
    assert pacer.deadlines.slipped == 0
    assert pacer.deadlines.farthest < sum(oversleeps) + PERIOD


def test_what_lags_by_more_than_can_be_made_up_gets_a_new_grid():
    world = World([3_000_000_000])
    pacer = world.pacer(catch_up=0.4)
    pacer.wait(0)
    pacer.wait(1)
    assert pacer.deadlines.slipped == int(3_000_000_000 / PERIOD)
    assert 0 <= world.now - pacer.due < PERIOD


def test_a_late_tick_moves_the_grid_and_nothing_is_run_in_a_burst():
    world = World()
    pacer = world.pacer(tick_seconds=Fraction(1, 1000))
    origin = world.now
    times = begun(world, pacer, [100_000, 100_000, 3_400_000, 100_000, 100_000, 100_000])
    assert [(at - origin) * 1e-6 for at in times] == pytest.approx([0, 1, 2, 5.4, 6, 7], abs=1e-3)
    assert (pacer.deadlines.misses, pacer.deadlines.slipped) == (1, 2)
    assert pacer.deadlines.worst * 1e-6 == pytest.approx(2.4, abs=1e-3)


def test_a_miss_is_told_by_what_made_it():
    world = World()
    pacer = world.pacer()
    pacer.work.begin(["models", "link.read"])
    pacer.wait(0)
    world.oversleep = [2_000_000]
    pacer.wait(1)
    world.work(100_000, interrupted=2_500_000)
    pacer.wait(2)
    pacer.work.add(0, 30_000)
    pacer.work.add(1, 2_500_000)
    world.work(2_530_000)
    pacer.wait(3)
    assert pacer.deadlines.causes == dict.fromkeys(MissCause, 1)
    assert pacer.deadlines.longest == {"link.read": 1}
    assert pacer.summary()["work"]["link.read"]["worst"] == pytest.approx(2.5e-3)


def test_a_slewed_period_moves_the_next_tick_and_never_this_one():
    world = World()
    pacer = world.pacer()
    pacer.wait(0)
    pacer.wait(1)
    due = pacer.due
    pacer.slew(200e-6)
    assert pacer.due == due
    for tick in range(2, 1026):
        pacer.wait(tick)
    assert pacer.due - due == pytest.approx(1024 * PERIOD * (1 + 200e-6), abs=2)
    due = pacer.due
    pacer.slew(0.0)
    pacer.wait(1026)
    assert pacer.due - due == pytest.approx(PERIOD, abs=2)


def test_the_policy_stop_says_which_tick():
    world = World()
    pacer = world.pacer(policy="stop")
    pacer.wait(0)
    pacer.wait(1)
    world.oversleep = [2_000_000]
    with pytest.raises(RunError, match=r"tick 2 began 2 ms after its deadline"):
        pacer.wait(2)


def test_percentiles_are_the_sorted_list():
    deadlines = Deadlines()
    for micro in range(1000):
        deadlines.add(micro * 1000)
    assert deadlines.percentile(0.5) == pytest.approx(500e-6, abs=2e-6)
    assert deadlines.percentile(0.99) == pytest.approx(990e-6, abs=2e-6)
    deadlines.add(50_000_000)
    assert deadlines.percentile(1.0) == pytest.approx(0.05)
    assert deadlines.summary()["worst"] == pytest.approx(0.05)


def test_the_plain_sleep_is_absolute():
    for _ in range(5):
        until = time.monotonic_ns() + 2_000_000
        sleep_until(until)
        # time.sleep may be a clock's resolution short; the pacer asks again.
        assert time.monotonic_ns() >= until - 1_000_000
    sleep_until(0)
