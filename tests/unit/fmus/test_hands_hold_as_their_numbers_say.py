"""Arms and grips by name: their impedance at every frequency, their source, and no jump between."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fmus.development import Instance
from fmus.operator.hands import CUSTOM_GRIP, HANDS

T = 1 / 1024
HALF_A_TICK = 0.025
"""At 8 Hz, w T / 2: the finger's velocity is held over a step."""
ARMS = {"arm_soft": (67.5, 4.56), "arm": (135.0, 6.45), "arm_stiff": (270.0, 9.12)}
GRIPS = {
    "grip_1_newton": (300.0, 3.0),
    "grip_2_newton": (600.0, 4.5),
    "grip_3_newton": (900.0, 6.0),
}
MASS = 0.554
NUMBER = {hand.name: number for number, hand in enumerate(HANDS, start=1)}


def shaken(frequency: float, **parameters: Any) -> complex:
    """Force over velocity (N·s/m) of a finger that is moved in a sine, after it has swung in."""
    user = Instance("operator", **parameters)
    user.initialise()
    period = round(1 / (frequency * T))
    w = 2 * math.pi / (period * T)
    ticks = period * max(3, math.ceil(3 / (period * T)))
    force = np.zeros(ticks)
    for tick in range(ticks):
        t = tick * T
        user.set(
            {
                "position": (1e-3 * math.sin(w * t), 0.0),
                "velocity": (1e-3 * w * math.cos(w * t), 0.0),
            }
        )
        force[tick] = user["force"][0]
        user.step()
    last = np.arange(ticks - period, ticks)
    at = 2 / period * np.sum(force[last] * np.exp(-1j * w * T * last))
    return -complex(at) / (1e-3 * w)


def expected(frequency: float, k: float, b: float, m: float, grip: tuple[float, float]) -> complex:
    s = 2j * math.pi * frequency
    arm, fingers = m * s + b + k / s, grip[1] + grip[0] / s
    return 1 / (1 / arm + 1 / fingers)


@pytest.mark.parametrize("name", GRIPS)
@pytest.mark.parametrize("frequency", [2.0, 8.0])
def test_a_grip_is_in_series_with_an_arm_that_has_mass(name: str, frequency: float) -> None:
    period = 1 / (round(1 / (frequency * T)) * T)
    want = expected(period, *ARMS["arm"], MASS, GRIPS[name])
    assert shaken(frequency, impedance=NUMBER[name]) == pytest.approx(want, rel=HALF_A_TICK)
    without = expected(period, *ARMS["arm"], 0.0, GRIPS[name])
    assert abs(without - want) > 0.05 * abs(want), "the mass does matter"


def test_a_grip_of_ones_own_takes_its_five_numbers() -> None:
    given = {
        "stiffness": [200.0, 1.0],
        "damping": [5.0, 1.0],
        "hand_mass": 0.3,
        "grip_stiffness": 500.0,
        "grip_damping": 2.0,
    }
    want = expected(8.0, 200.0, 5.0, 0.3, (500.0, 2.0))
    assert shaken(8.0, impedance=CUSTOM_GRIP, **given) == pytest.approx(want, rel=HALF_A_TICK)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_is_its_spring_and_damper(name: str) -> None:
    user = Instance("operator", impedance=NUMBER[name])
    user.initialise(initial_position=[0.01, -0.02])
    user.set({"position": (0.003, 0.0), "velocity": (0.1, -0.2)})
    k, b = ARMS[name]
    assert user["force"] == pytest.approx([k * 0.007 - b * 0.1, -k * 0.02 + b * 0.2], rel=1e-12)


def test_a_hand_that_takes_a_grip_while_it_runs_begins_where_the_finger_is() -> None:
    user = Instance("operator", impedance=1)
    user.initialise(initial_position=[0.05, 0.0])
    user.set({"position": (0.02, 0.0), "velocity": (0.0, 0.0)})
    for _ in range(5):
        user.step()
    user.set({"impedance": NUMBER["grip_2_newton"]})
    assert user["force"] == pytest.approx([0.0, 0.0], abs=1e-12)
    for _ in range(4000):
        user.step()
    series = 1 / (1 / 600 + 1 / 135)
    assert user["force"][0] == pytest.approx(series * 0.03, rel=1e-3)


def test_a_grip_without_a_mass_is_refused() -> None:
    with pytest.raises(Exception, match="hand_mass above 0"):
        Instance("operator", impedance=CUSTOM_GRIP, hand_mass=0.0).initialise()
