"""The pantograph moves as Lagrange's equations of the same links say, and keeps its energy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.development import Instance
from fmus.shared.mechanism.device import presets
from tests.support.physics.planar_oracle import IDEAL_DEVICE, Array, T, preset_bar

FINGER = 0.06
BAR = preset_bar(0)


def value(name: str) -> float:
    return presets("DYNAMICS")[name][0]


def points(joints: Array) -> Array:
    """What has mass: centres of both distal links, their angles, the tip."""
    elbows, tip = BAR.elbows(joints), BAR.tip(joints)
    centres = [(elbow + tip) / 2 for elbow in elbows]
    angles = [np.arctan2(*(tip - elbow)[::-1]) for elbow in elbows]
    return np.array([*centres[0], *centres[1], *angles, *tip])


@cache
def masses() -> Array:
    m, inertia = value("distal_mass"), value("distal_inertia")
    end = value("tip_mass") + FINGER
    return np.diag([m, m, m, m, inertia, inertia, end, end])


def mass_matrix(joints: Array) -> Array:
    step = 1e-5
    j = np.array([(points(joints + e) - points(joints - e)) / (2 * step) for e in step * np.eye(2)])
    return (value("proximal_inertia") + value("rotor_inertia")) * np.eye(2) + j @ masses() @ j.T


def acceleration(joints: Array, rate: Array, torque: Array, force: Array) -> Array:
    """Lagrange's equations with Christoffel symbols from differences of the mass matrix."""
    step = 1e-4
    slope = np.array(
        [(mass_matrix(joints + e) - mass_matrix(joints - e)) / (2 * step) for e in step * np.eye(2)]
    )
    coriolis = np.einsum("kij,k,j->i", slope, rate, rate) - 0.5 * np.einsum(
        "ijk,j,k->i", slope, rate, rate
    )
    drive = torque + BAR.jacobian(joints).T @ force
    return np.linalg.solve(mass_matrix(joints), drive - coriolis)


def pantograph(**parameters: float) -> Instance:
    device = Instance("pantograph", finger_mass=FINGER, **{**IDEAL_DEVICE, **parameters})
    device.initialise()
    return device


def test_motion_equals_lagranges_equations() -> None:
    torque, force, ticks = np.array([0.02, -0.03]), np.array([1.2, 0.5]), 70
    device = pantograph(substeps=64)
    device["motor_torque"], device["hand_force"] = torque, force
    start = device["true_joint_angle"]
    for _ in range(ticks):
        device.step(T)

    def slope(_t: float, y: Array) -> Array:
        return np.concatenate([y[2:], acceleration(y[:2], y[2:], torque, force)])

    exact = solve_ivp(
        slope, (0, ticks * T), np.concatenate([start, [0.0, 0.0]]), rtol=1e-8, atol=1e-10
    ).y[:, -1]
    travelled = np.linalg.norm(exact[:2] - start)
    assert travelled > 0.2
    np.testing.assert_allclose(device["true_joint_angle"], exact[:2], rtol=0, atol=2e-7)
    speed = BAR.jacobian(exact[:2]) @ exact[2:]
    np.testing.assert_allclose(device["tip_velocity"], speed, rtol=0, atol=2e-6)
    kinetic = 0.5 * exact[2:] @ mass_matrix(exact[:2]) @ exact[2:]
    assert device["energy"] == pytest.approx(kinetic, rel=1e-5)


def energy_error(substeps: int) -> float:
    """Largest relative change of energy while coasting without friction for 50 ms."""
    device = pantograph(substeps=substeps)
    device["hand_force"] = (1.5, 0.8)
    for _ in range(30):
        device.step(T)
    device["hand_force"] = (0.0, 0.0)
    start, worst = device["energy"], 0.0
    for _ in range(50):
        device.step(T)
        worst = max(worst, abs(device["energy"] / start - 1))
    return worst


def test_energy_is_conserved_to_the_second_order() -> None:
    errors = [energy_error(substeps) for substeps in (1, 2, 4, 8, 16)]
    assert errors[3] < 1e-7
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 4.0, rtol=0.02)


def test_work_of_the_hand_becomes_kinetic_energy() -> None:
    device = pantograph(substeps=32)
    force = np.array([1.0, -0.6])
    device["hand_force"] = force
    start = device["tip_position"]
    for _ in range(40):
        device.step(T)
    work = force @ (device["tip_position"] - start)
    assert device["energy"] == pytest.approx(work, rel=1e-6)
