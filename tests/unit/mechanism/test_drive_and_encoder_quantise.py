"""What the DAC sends and what the encoders count."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance
from tests.support.physics.planar_oracle import IDEAL_DEVICE, T

torque = st.floats(-1.0, 1.0)
PER_VOLT = 0.0364 * 0.5


@pytest.fixture(scope="module")
def device() -> Instance:
    instance = Instance("pantograph")
    instance.initialise()
    return instance


def applied(device: Instance, value: float) -> float:
    device["motor_torque[1]"] = value
    return device["applied_torque[1]"]


@settings(deadline=None)
@given(value=torque)
def test_dac_truncates_towards_zero_within_its_range(device: Instance, value: float) -> None:
    sent = applied(device, value)
    step = 10.0 / 32767 * PER_VOLT
    code = sent / step
    assert code == pytest.approx(round(code), abs=1e-9)
    assert abs(sent) <= abs(value)
    assert sent * value >= 0
    assert abs(sent) <= 10.0 * PER_VOLT * (1 + 1e-12)
    if abs(value) < 10.0 * PER_VOLT:
        assert abs(value - sent) < step * (1 + 1e-9)
    assert applied(device, -value) == -sent
    assert applied(device, sent) == sent


@settings(deadline=None)
@given(first=torque, second=torque)
def test_a_larger_command_never_sends_less(device: Instance, first: float, second: float) -> None:
    low, high = sorted((first, second))
    assert applied(device, low) <= applied(device, high)


def test_nan_sends_zero(device: Instance) -> None:
    assert applied(device, float("nan")) == 0.0


def test_ideal_drive_sends_what_it_is_told() -> None:
    ideal = Instance(
        "pantograph", **IDEAL_DEVICE, dac_range=0.0, torque_limit=0.0, current_limit=0.0
    )
    ideal.initialise()
    for value in (1e-9, 0.1234567, -3.0):
        assert applied(ideal, value) == value


def test_torque_limit_comes_before_the_dac() -> None:
    limited = Instance("pantograph", torque_limit=0.1, dac_bits=0)
    limited.initialise()
    assert applied(limited, 0.5) == pytest.approx(0.1, rel=1e-15)
    assert applied(limited, -0.5) == pytest.approx(-0.1, rel=1e-15)


def test_amplifier_follows_as_a_first_order_lag() -> None:
    bandwidth = 50.0
    slow = Instance("pantograph", amplifier_bandwidth=bandwidth, dac_bits=0)
    slow.initialise()
    slow["motor_torque"] = (0.01, 0.0)
    final = 0.01 / 0.0364
    for tick in range(1, 6):
        slow.step(T)
        exact = final * (1 - np.exp(-2 * np.pi * bandwidth * tick * T))
        assert slow["motor_current[1]"] == pytest.approx(exact, rel=1e-12)


def test_amplifier_saturates() -> None:
    small = Instance("pantograph", amplifier_bandwidth=0.0, current_limit=1.0)
    small.initialise()
    small["motor_torque"] = (0.15, -0.15)
    np.testing.assert_array_equal(small["motor_current"], [1.0, -1.0])


@settings(deadline=None, max_examples=40)
@given(
    counts=st.integers(100, 100_000),
    x=st.floats(0.0, 0.08),
    y=st.floats(0.15, 0.22),
    offset=st.floats(-4, 4),
)
def test_encoder_counts_to_the_nearest_edge(counts: int, x: float, y: float, offset: float) -> None:
    device = Instance(
        "pantograph",
        encoder_counts=counts,
        encoder_offset=(offset, -offset),
        initial_tip_position=(x, y),
    )
    device.initialise()
    quantum = 2 * np.pi / counts
    off = device["joint_angle"] - device["true_joint_angle"]
    assert np.all(np.abs(off) <= quantum / 2 * (1 + 1e-9))
    expected = np.array([offset, -offset]) + device["encoder_count"] * quantum
    np.testing.assert_allclose(device["joint_angle"], expected, rtol=0, atol=1e-13)


def test_homing_error_is_not_seen_by_its_reader() -> None:
    device = Instance("pantograph", encoder_counts=0, encoder_bias=(0.01, -0.02))
    device.initialise()
    np.testing.assert_allclose(
        device["joint_angle"] - device["true_joint_angle"], [0.01, -0.02], atol=1e-15
    )


@pytest.mark.parametrize("delay", range(9))
def test_a_command_takes_effect_after_its_delay(delay: int) -> None:
    device = Instance("pantograph", **IDEAL_DEVICE, computation_delay_ticks=delay)
    device.initialise()
    commands = [0.001 * (k + 1) for k in range(20)]
    seen = []
    for command in commands:
        device["motor_torque"] = (command, 0.0)
        seen.append(device["applied_torque[1]"])
        device.step(T)
    expected = [0.0] * delay + commands[: len(commands) - delay]
    np.testing.assert_allclose(seen, expected, rtol=1e-12)


def test_the_delayed_torque_is_what_moves_the_device() -> None:
    def angles(delay: int) -> np.ndarray:
        device = Instance("pantograph", **IDEAL_DEVICE, computation_delay_ticks=delay)
        device.initialise()
        out = []
        for k in range(30):
            device["motor_torque"] = (0.01 * np.sin(0.5 * k), 0.0)
            out.append(device["true_joint_angle"])
            device.step(T)
        return np.array(out)

    np.testing.assert_array_equal(angles(3)[3:], angles(0)[:-3])
