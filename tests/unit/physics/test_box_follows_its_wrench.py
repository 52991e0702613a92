"""The box moves by its wrenches as an independent integration says, and rests when it rests."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Array, Bench, T

AXES = ("x", "y", "theta")
MASS, INERTIA, SIDE, GRAVITY = 0.4, 6.7e-4, 0.1, 9.81
WALL = {
    "wall_1.enabled": True,
    "wall_1.point_x": 0.0,
    "wall_1.point_y": 0.058,
    "wall_1.normal_x": -0.2,
    "wall_1.normal_y": -1.9,
    "wall_3.enabled": True,
    "wall_3.point_x": -0.057,
    "wall_3.normal_x": 1.0,
    "wall_3.normal_y": 0.1,
}


def integrate(rule: int, pose: Array, velocity: Array, wrench: Array) -> tuple[Array, Array]:
    """One tick of Euler's rule with implicit ground friction."""
    inertia = np.array([MASS, MASS, INERTIA])
    new = velocity + T * wrench / inertia
    speed = np.linalg.norm(new[:2])
    if speed > 0:
        new[:2] *= max(0.0, 1 - 0.05 * GRAVITY * T / speed)
    if new[2] != 0:
        torque = 0.15 * MASS * GRAVITY * 0.383 * SIDE
        new[2] *= max(0.0, 1 - torque * T / (INERTIA * abs(new[2])))
    moved = {0: new, 1: velocity, 2: (new + velocity) / 2}[rule]
    return pose + T * moved, new


@pytest.mark.parametrize("rule", [0, 1, 2], ids=["semi_implicit", "explicit", "zero_order_hold"])
def test_pose_and_velocity_follow_from_the_wrenches(rule: int) -> None:
    compensation = np.array([-0.8, 0.5, 0.01])
    bench = Bench(
        "distributed_workstation",
        [(0.0, -0.05)],
        [np.pi],
        integration=rule,
        **{f"compensation.{axis}": value for axis, value in zip(AXES, compensation, strict=True)},
        **WALL,
        **{"initial_box_pose.theta": 0.1},
    )
    bench["peer_1.box_x"], bench["peer_1.box_theta"] = -0.01, 0.3
    bench["peer_1.source_tick"], bench["peer_1.status"] = 0, 11 + 32
    bench["peer_1.finger_1_position"] = (0.045, 0.02)
    touched = moved = 0.0
    for tick in range(400):
        push = min(tick * 4e-5, 0.009)
        bench.put((0.01 + 0.01 * np.sin(0.02 * tick), -0.053 + push))
        pose, velocity = bench.planar("box_pose"), bench.planar("box_velocity")
        wrench = sum(bench.planar(f"{name}_wrench") for name in ("finger", "wall", "coupling"))
        touched = max(touched, bench["wall_penetration"])
        pose, velocity = integrate(rule, pose, velocity, wrench - compensation * velocity)
        bench.step()
        np.testing.assert_allclose(bench.planar("box_pose"), pose, rtol=0, atol=1e-14)
        np.testing.assert_allclose(bench.planar("box_velocity"), velocity, rtol=0, atol=1e-12)
        moved = max(moved, abs(velocity[1]))
    assert touched > 1e-5
    assert moved > 0.01
    energy = 0.5 * np.sum([MASS, MASS, INERTIA] * bench.planar("box_velocity") ** 2)
    assert bench["box_energy"] == pytest.approx(energy, rel=1e-12)


def test_a_box_at_rest_stays_at_rest_to_the_bit() -> None:
    start = {"initial_box_pose.x": 0.1, "initial_box_pose.y": -0.3, "initial_box_pose.theta": 0.7}
    bench = Bench("distributed_workstation", [(0.5, 0.5)], **start)
    bench.put((0.5, 0.5))
    bench["peer_1.source_tick"] = 0
    for axis, value in zip(("box_x", "box_y", "box_theta"), start.values(), strict=True):
        bench[f"peer_1.{axis}"] = value
    for _ in range(200):
        bench.step()
    np.testing.assert_array_equal(bench.planar("box_pose"), list(start.values()))
    np.testing.assert_array_equal(bench.planar("box_velocity"), 0.0)


def test_a_push_below_ground_friction_moves_nothing() -> None:
    bench = Bench("distributed_workstation", [(0.0, 0.05)], peers=0)
    depth = 0.9 * 0.05 * MASS * GRAVITY / 800
    bench.put((0.0, 0.05 - depth))
    for _ in range(300):
        bench.step()
    assert bench["finger_1.normal_force"] > 0.17
    np.testing.assert_array_equal(bench.planar("box_pose"), 0.0)


def test_ground_friction_stops_a_sliding_box_where_coulomb_says() -> None:
    """v0^2 / (2 mu g), after a push; one tick's travel is the tolerance."""
    bench = Bench("distributed_workstation", [(0.0, 0.05)], peers=0)
    depth = 0.0
    for _ in range(40):
        depth += 2e-4
        bench.put((0.0, 0.05 - depth))
        bench.step()
    bench.put((0.0, 0.07))
    bench.step()
    start, speed = bench["box_pose.y"], abs(bench["box_velocity.y"])
    assert speed > 0.05
    while bench["box_velocity.y"] != 0.0:
        bench.step()
    travelled = abs(bench["box_pose.y"] - start)
    assert travelled == pytest.approx(speed**2 / (2 * 0.05 * GRAVITY), abs=speed * T)


def test_a_box_pressed_flat_against_a_wall_stands_on_two_corners() -> None:
    wall = {"wall_2.enabled": True, "wall_2.point_y": -0.05, "wall_2.normal_y": 3.0}
    bench = Bench("distributed_workstation", [(0.0, 0.05)], peers=0, **wall)
    for tick in range(3000):
        bench.put((0.0, 0.05 - 0.003 * min(tick / 500, 1.0)))
        bench.step()
    force = bench["finger_1.normal_force"]
    assert bench["wall_wrench.y"] == pytest.approx(force, abs=0.05 * MASS * GRAVITY)
    assert bench["wall_penetration"] == pytest.approx(bench["wall_wrench.y"] / 8000, rel=1e-3)
    assert abs(bench["box_pose.theta"]) < 1e-12
