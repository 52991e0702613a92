"""The pacer of a played run: pause, single steps and slow motion, with beats all the while."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from cosim.live.control import PlayControl
from cosim.live.play_pacer import PlayPacer
from cosim.realtime.pacing import DeadlinePacer

TICK = 1_000_000


class World:
    """A clock that sleeping moves, and somebody who asks for things at times."""

    def __init__(self, wishes: dict[int, dict], monkeypatch) -> None:
        self.now, self.beats, self.ends_at = 0, 0, 10**15
        self.control = PlayControl.create()
        self._asked = PlayControl.attach(self.control.path)
        self._wishes = dict(wishes)
        monkeypatch.setattr("cosim.live.play_pacer.time.sleep", self.pass_by)
        inner = DeadlinePacer(
            tick_seconds=Fraction(1, 1000),
            clock=lambda: self.now,
            sleep=self.until,
            busy=lambda: 0,
        )
        self.pacer = PlayPacer(inner, self.control, self)

    @property
    def stop_asked(self) -> bool:
        return self.now > self.ends_at

    def beat(self) -> None:
        self.beats += 1

    def until(self, deadline: int) -> None:
        self.pass_by(max(0, deadline - self.now) * 1e-9)

    def pass_by(self, seconds: float) -> None:
        self.now += round(seconds * 1e9)
        for moment in sorted(self._wishes):
            if moment <= self.now:
                self._asked.hear(self._wishes.pop(moment))

    def ticks_at(self, count: int) -> list[float]:
        """When ticks ran, in periods."""
        self.pacer.start(0)
        moments = []
        for tick in range(count):
            self.pacer.wait(tick)
            moments.append(self.now / TICK)
        return moments


@pytest.fixture
def world(monkeypatch):
    made: list[World] = []

    def make(wishes):
        made.append(World(wishes, monkeypatch))
        return made[-1]

    yield make
    for each in made:
        each.control.remove()


def test_a_pause_holds_the_next_tick_and_counts_as_no_miss(world):
    here = world({10 * TICK: {"paused": True}, 510 * TICK: {"paused": False}})
    moments = here.ticks_at(20)
    gaps = [b - a for a, b in pairwise(moments)]
    assert max(gaps) == pytest.approx(500, abs=5)
    assert sorted(gaps)[-2] <= 1.01
    assert here.pacer.deadlines.misses == 0
    assert here.beats > 200, "who watches the loop sees that it lives"


def test_a_step_runs_one_tick(world):
    wishes = {5 * TICK: {"paused": True}, 100 * TICK: {"step": True}, 200 * TICK: {"step": True}}
    here = world(wishes | {300 * TICK: {"paused": False}})
    moments = here.ticks_at(12)
    gaps = [round(b - a) for a, b in pairwise(moments)]
    assert [gap for gap in gaps if gap > 50] == [pytest.approx(97, abs=8)] + [
        pytest.approx(100, abs=5)
    ] * 2


def test_slow_motion_stretches_the_ticks(world):
    here = world({10 * TICK: {"speed": 0.25}})
    moments = here.ticks_at(40)
    assert moments[9] - moments[8] == pytest.approx(1)
    assert moments[39] - moments[38] == pytest.approx(4)
    assert here.pacer.deadlines.misses == 0


def test_an_end_is_heard_in_a_pause(world):
    here = world({3 * TICK: {"paused": True}})
    here.ends_at = 50 * TICK
    with pytest.raises(KeyboardInterrupt):
        here.ticks_at(100)
    assert here.now < 60 * TICK
