"""The operator's tracked trajectory: samples of a pointer become a hand without steps."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest

from tests.support.fmus.fmu_support import Fmu

TICK = 1 / 1024
PARAMETERS = {"trajectory": 4, "impedance": 1}
STIFFNESS, DAMPING = 100.0, 3.0


class Hand:
    """An operator whose finger stands at the origin, fed samples of a pointer."""

    def __init__(self, **parameters) -> None:
        self.fmu = Fmu("operator", "fmi3")
        for name, value in (PARAMETERS | parameters).items():
            self.fmu.set(name, value)
        self.fmu.start()
        self.count, self.taken = 0, 0.0
        self.tick = 0

    def sample(self, x: float, y: float, *, valid: bool = True, age: float = 0.0) -> None:
        self.count += 1
        self.taken = self.time - age
        self.fmu.set("target_position[1]", x)
        self.fmu.set("target_position[2]", y)
        self.fmu.set("target_valid", valid)
        self.fmu.set("target_count", self.count)

    def step(self) -> None:
        self.fmu.set("target_age", self.time - self.taken)
        self.fmu.step()
        self.tick += 1

    @property
    def time(self) -> float:
        return self.tick * TICK

    def reference(self) -> tuple[float, float]:
        return self._pair("reference_position")

    def force(self) -> tuple[float, float]:
        return self._pair("force")

    def _pair(self, name: str) -> tuple[float, float]:
        return float(self.fmu.get(f"{name}[1]")), float(self.fmu.get(f"{name}[2]"))


@pytest.fixture
def hand():
    made = Hand()
    yield made
    made.fmu.__exit__()


def circle(t: float) -> tuple[float, float]:
    """4 cm across, half a turn a second: what a hand does with a box."""
    return 0.04 * sin(pi * t), 0.04 * (1 - cos(pi * t))


def follow(hand: Hand, seconds: float, rate: float = 60.0, age: float = 0.0):
    """Samples at ``rate`` of the circle; reference, wanted place and force, tick by tick."""
    rows, due = [], 0.0
    while hand.time < seconds:
        if hand.time >= due:
            hand.sample(*circle(hand.time - age), age=age)
            due += 1 / rate
        hand.step()
        rows.append([*hand.reference(), *circle(hand.time), *hand.force()])
    return np.array(rows)


def test_sixty_samples_a_second_have_no_lag_and_no_steps(hand):
    rows = follow(hand, 3.0)[1024:]
    away = np.hypot(*(rows[:, :2] - rows[:, 2:4]).T)
    speed = 0.04 * pi
    assert np.median(away) / speed < 3e-3, "less than 3 ms of lag"
    steps = np.hypot(*np.diff(rows[:, 4:], axis=0).T)
    assert steps.max() < 0.1


def test_a_sample_that_is_old_is_moved_on_by_its_age(hand):
    rows = follow(hand, 3.0, age=0.01)[1024:]
    away = np.hypot(*(rows[:, :2] - rows[:, 2:4]).T)
    assert np.median(away) / (0.04 * pi) < 6e-3, "of the 10 ms and the interval in between"


def test_a_pointer_that_stops_is_not_run_past(hand):
    for _ in range(30):
        hand.sample(0.3 * hand.time, 0.0)
        for _ in range(17):
            hand.step()
    last = 0.3 * (hand.time - 17 * TICK)
    farthest = 0.0
    for _ in range(600):
        hand.step()
        farthest = max(farthest, hand.reference()[0])
    assert farthest < last + 0.3 * 1.6 / 60 + 2e-3, "one and a half intervals and the overshoot"


def test_a_jump_is_no_faster_than_the_limit(hand):
    hand.sample(0.0, 0.0)
    hand.step()
    hand.sample(5.0, -5.0)
    before = hand.reference()
    for _ in range(500):
        hand.step()
        after = hand.reference()
        assert hypot(after[0] - before[0], after[1] - before[1]) <= 1.0 * TICK * 1.0001
        before = after


def test_silence_is_held_and_then_the_hand_lets_go(hand):
    hand.sample(0.03, 0.0)
    for _ in range(1024):
        hand.step()
    holding = hand.force()[0]
    assert holding == pytest.approx(STIFFNESS * 0.03, rel=1e-3)
    hand.sample(0.03, 0.0, valid=False)
    for _ in range(500):
        hand.step()
        assert hand.force()[0] == pytest.approx(holding, rel=1e-3)
    forces = []
    for _ in range(400):
        hand.step()
        forces.append(hand.force()[0])
    assert forces[-1] == 0.0
    assert max(abs(np.diff(forces))) < 0.02


def test_who_comes_back_takes_hold_without_a_jerk(hand):
    hand.sample(0.03, 0.0)
    for _ in range(600):
        hand.step()
    hand.sample(0.03, 0.0, valid=False)
    for _ in range(1024):
        hand.step()
    hand.sample(-0.04, 0.01)
    forces = []
    for _ in range(1024):
        hand.step()
        forces.append(hand.force()[0])
    assert max(abs(np.diff(forces))) < 0.1
    assert forces[-1] == pytest.approx(-STIFFNESS * 0.04, rel=1e-3)


def test_until_somebody_comes_it_is_the_emulated_user():
    hand = Hand(via_count=1, **{"via_time[1]": 0.5, "via_x[1]": 0.02})
    hand.fmu.set("target_valid", False)
    for _ in range(600):
        hand.step()
    assert hand.reference() == (pytest.approx(0.02), 0.0)
    hand.fmu.__exit__()
