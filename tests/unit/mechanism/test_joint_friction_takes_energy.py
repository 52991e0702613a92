"""Coulomb friction takes energy only, holds exactly, and does not chatter."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance
from tests.support.physics.planar_oracle import IDEAL_DEVICE, T

FREE = {**IDEAL_DEVICE, "joint_minimum": 0.5, "joint_maximum": 4.5}


def pantograph(**parameters: float) -> Instance:
    device = Instance("pantograph", **{**FREE, **parameters})
    device.initialise()
    return device


@settings(deadline=None, max_examples=25)
@given(
    friction=st.floats(1e-4, 2e-2),
    viscous=st.floats(0.0, 1e-3),
    angle=st.floats(0, 2 * np.pi),
    push=st.integers(3, 15),
)
def test_energy_never_rises_without_a_drive(
    friction: float, viscous: float, angle: float, push: int
) -> None:
    device = pantograph(coulomb_friction=friction, viscous_friction=viscous)
    device["hand_force"] = 2.5 * np.array([np.cos(angle), np.sin(angle)])
    for _ in range(push):
        device.step(T)
    device["hand_force"] = (0.0, 0.0)
    energy = device["energy"]
    for _ in range(60):
        device.step(T)
        assert device["energy"] <= energy * (1 + 1e-6)
        energy = device["energy"]


def test_friction_stops_the_device_for_good() -> None:
    device = pantograph(coulomb_friction=1e-2)
    device["hand_force"] = (1.0, 0.5)
    for _ in range(10):
        device.step(T)
    device["hand_force"] = (0.0, 0.0)
    for _ in range(200):
        device.step(T)
    rest = device["true_joint_angle"]
    assert device["energy"] == 0.0
    for _ in range(50):
        device.step(T)
    np.testing.assert_array_equal(device["true_joint_angle"], rest)


def test_a_torque_below_friction_moves_nothing() -> None:
    device = pantograph(coulomb_friction=3e-3)
    start = device["true_joint_angle"]
    device["motor_torque"] = (2.9e-3, -2.9e-3)
    for _ in range(100):
        device.step(T)
    np.testing.assert_array_equal(device["true_joint_angle"], start)
    device["motor_torque"] = (3.3e-3, -3.3e-3)
    for _ in range(100):
        device.step(T)
    assert np.all(np.abs(device["true_joint_angle"] - start) > 1e-4)


def test_steady_sliding_meets_exactly_the_whole_friction() -> None:
    """The work that friction takes while one joint turns is its torque times the angle."""
    device = pantograph(coulomb_friction=2e-3, substeps=64)
    device["motor_torque"] = (0.02, -0.02)
    start = device["true_joint_angle"]
    for _ in range(30):
        device.step(T)
    turned = device["true_joint_angle"] - start
    drive = np.array([0.02, -0.02]) @ turned
    taken = 2e-3 * np.sum(np.abs(turned))
    assert abs(device["energy"] - (drive - taken)) < 0.002 * drive


def test_mechanical_stops_hold_the_joints() -> None:
    device = Instance("pantograph", **IDEAL_DEVICE)
    device.initialise()
    device["hand_force"] = (0.0, 2.0)
    for _ in range(1500):
        device.step(T)
    joints = device["true_joint_angle"]
    np.testing.assert_allclose(joints, [np.radians(85), np.radians(95)], atol=0.02)
