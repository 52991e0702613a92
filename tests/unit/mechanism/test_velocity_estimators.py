"""FOAW finds the longest line through the counts; late samples change its denominator only."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance
from tests.support.physics.planar_oracle import T, preset_bar

BAR = preset_bar(0)
QUANTUM = 2 * np.pi / 20000
HOME = np.array([2.28, 0.86])


def client(**parameters: float) -> Instance:
    instance = Instance("remote_client", fingers=1, **parameters)
    instance.initialise()
    return instance


def estimated_rate(instance: Instance, joints: np.ndarray) -> np.ndarray:
    """Joint velocities (rad/s) behind the tip velocity that the model reports."""
    return np.linalg.solve(BAR.jacobian(joints), instance["finger_1.velocity"])


def foaw(samples: list[tuple[int, float]], window: int, quantum: float) -> float:
    """The definition: the longest end-to-end line that passes within a quantum of all between."""
    (now, newest), best = samples[-1], 0.0
    older = [s for s in samples[:-1] if now - s[0] <= window][::-1]
    for length in range(1, len(older) + 1):
        tick, value = older[length - 1]
        slope = (newest - value) / ((now - tick) * T)
        inside = all(
            abs(value + slope * (t - tick) * T - y) <= quantum * (1 + 1e-6)
            for t, y in older[: length - 1]
        )
        if not inside:
            break
        best = slope
    return best


@settings(deadline=None, max_examples=60)
@given(
    counts=st.lists(st.tuples(st.integers(-3, 3), st.integers(-40, 40)), min_size=2, max_size=45),
    window=st.integers(1, 31),
    drift=st.floats(-20, 20),
)
def test_foaw_equals_its_definition(
    counts: list[tuple[int, int]], window: int, drift: float
) -> None:
    instance = client(velocity_window=window)
    history: tuple[list, list] = ([], [])
    for tick, (small, large) in enumerate(counts):
        code = np.floor([drift * tick / 16 + small, large])
        joints = HOME + QUANTUM * code
        instance["finger_1.joint_angle"] = joints
        for axis in (0, 1):
            history[axis].append((tick, joints[axis]))
        expected = [foaw(history[axis], window, QUANTUM) for axis in (0, 1)]
        np.testing.assert_allclose(estimated_rate(instance, joints), expected, atol=2e-6, rtol=1e-6)
        instance.step(T)


@settings(deadline=None, max_examples=40)
@given(
    ages=st.lists(st.integers(0, 6), min_size=5, max_size=40),
    window=st.integers(4, 31),
    rate=st.floats(-3, 3),
)
def test_late_samples_keep_their_own_times(ages: list[int], window: int, rate: float) -> None:
    """A joint that turns steadily and is read now and then is estimated at its true rate."""
    instance = client(velocity_window=window, **{"finger_1.encoder_counts": 0})
    tick, read, joints = 0, [0], HOME
    for age in [0, *ages]:
        for late in range(age + 1):
            if late == 0:
                joints = HOME + rate * T * tick * np.array([1.0, -0.5])
            instance["finger_1.joint_angle"] = joints
            instance["finger_1.sample_age"] = late
            if len(read) > 1 and read[-1] - read[-2] <= window:
                np.testing.assert_allclose(
                    estimated_rate(instance, joints), [rate, -0.5 * rate], atol=1e-5
                )
            instance.step(T)
            tick += 1
        read.append(tick)


def test_the_estimate_restarts_after_a_gap_longer_than_the_window() -> None:
    instance = client(velocity_window=4)
    for tick in range(10):
        instance["finger_1.joint_angle"] = HOME + 0.001 * tick
        instance.step(T)
    instance["finger_1.joint_angle"] = HOME + 0.01
    assert np.hypot(*instance["finger_1.velocity"]) > 0
    for late in range(1, 6):
        instance["finger_1.sample_age"] = late
        instance.step(T)
    instance["finger_1.sample_age"] = 0
    np.testing.assert_array_equal(instance["finger_1.velocity"], 0.0)


def test_first_sample_has_no_velocity() -> None:
    instance = client()
    instance["finger_1.joint_angle"] = HOME
    np.testing.assert_array_equal(instance["finger_1.velocity"], 0.0)


def test_finite_difference_spans_the_window_on_the_tip() -> None:
    instance = client(velocity_estimator=1, velocity_window=5, **{"finger_1.encoder_counts": 0})
    joints = [HOME + 0.003 * np.array([k, np.sin(k)]) for k in range(12)]
    for k, now in enumerate(joints):
        instance["finger_1.joint_angle"] = now
        past = max(0, k - 5)
        expected = (BAR.world(now) - BAR.world(joints[past])) / ((k - past) * T) if k else 0.0
        np.testing.assert_allclose(instance["finger_1.velocity"], expected, atol=1e-9)
        instance.step(T)


def test_foaw_is_quieter_than_a_short_difference_on_an_edge() -> None:
    rng = np.random.default_rng(0)
    angle = QUANTUM * (0.5 + 0.1 * rng.standard_normal(400))
    noise = {}
    difference = {"velocity_estimator": 1, "velocity_window": 1}
    for name, parameters in {"foaw": {}, "difference": difference}.items():
        instance, speeds = client(**parameters), []
        for value in angle:
            code = np.floor(value / QUANTUM + 0.5)
            instance["finger_1.joint_angle"] = HOME + QUANTUM * code
            speeds.append(np.hypot(*instance["finger_1.velocity"]))
            instance.step(T)
        noise[name] = np.sqrt(np.mean(np.square(speeds)))
    assert noise["foaw"] < 0.2 * noise["difference"]


@pytest.mark.parametrize("window", [0, 32])
def test_a_window_outside_the_memory_is_refused(window: int) -> None:
    with pytest.raises(Exception, match="velocity_window"):
        client(velocity_window=window)
