"""A peer acts through its weight, and not at all while it is invalid, gone or speaks nonsense."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.physics.planar_oracle import Array, Bench, T

K, B, KR, BR = 77.5, 10.0, 2.2, 0.05
STATUS = 11 + 32
small = st.floats(-0.05, 0.05)


def station(**parameters: Any) -> Bench:
    bench = Bench("distributed_workstation", [(0.5, 0.5)], **parameters)
    bench.put((0.5, 0.5))
    say(bench, source_tick=0)
    return bench


def say(bench: Bench, peer: int = 1, **values: Any) -> None:
    for name, value in values.items():
        bench[f"peer_{peer}.{name}"] = value


@settings(deadline=None, max_examples=40)
@given(
    pose=st.tuples(small, small, st.floats(-3, 3)),
    velocity=st.tuples(small, small, small),
    turns=st.integers(-2, 2),
    weight=st.floats(0, 1),
)
def test_copies_are_pulled_together(
    pose: tuple[float, ...], velocity: tuple[float, ...], turns: int, weight: float
) -> None:
    bench = station(**{"initial_box_pose.theta": 2 * np.pi * turns})
    bench["peer_weight[1]"] = weight
    say(bench, box_x=pose[0], box_y=pose[1], box_theta=pose[2])
    say(bench, box_vx=velocity[0], box_vy=velocity[1], box_omega=velocity[2])
    expected = [
        K * pose[0] + B * velocity[0],
        K * pose[1] + B * velocity[1],
        KR * pose[2] + BR * velocity[2],
    ]
    actual = bench.planar("coupling_wrench")
    np.testing.assert_allclose(actual, weight * np.array(expected), rtol=0, atol=1e-12)


def test_the_shorter_way_round_is_taken() -> None:
    bench = station(**{"initial_box_pose.theta": 3.0})
    say(bench, box_theta=-3.0)
    assert bench["coupling_wrench.theta"] == pytest.approx(KR * (2 * np.pi - 6.0), rel=1e-12)


def finger_on_box(weight: float, ticks: int) -> Array:
    """Forces of a peer's sliding and sticking finger on a box that cannot move."""
    bench = station(mass=1e9, inertia=1e9)
    bench["peer_weight[1]"] = weight
    out = []
    for tick in range(ticks):
        place = (0.03 * np.sin(0.05 * tick), 0.048 - 0.002 * np.cos(0.03 * tick))
        say(bench, status=STATUS, finger_1_position=place, box_x=bench["box_pose.x"])
        say(bench, finger_1_velocity=(0.03 * 0.05 / T * np.cos(0.05 * tick), 0.0))
        out.append(bench.planar("coupling_wrench"))
        bench.step()
    return np.array(out)


@pytest.mark.parametrize("weight", [0.0, 0.25, 0.7])
def test_a_peers_finger_pushes_by_its_weight(weight: float) -> None:
    whole = finger_on_box(1.0, 150)
    assert np.abs(whole[:, 0]).max() > 0.1
    np.testing.assert_allclose(finger_on_box(weight, 150), weight * whole, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        {"peer_valid[1]": False},
        {"peer_weight[1]": 0.0},
        {"peer_weight[1]": float("nan")},
        {"peer_1.source_tick": -1},
        {"peer_1.finger_1_position": (float("nan"), 0.0), "peer_1.box_x": float("inf")},
    ],
    ids=str,
)
def test_a_peer_that_is_not_there_does_nothing(change: dict[str, Any]) -> None:
    bench = station()
    say(bench, finger_1_position=(0.0, 0.045), box_x=0.01, status=STATUS)
    assert bench["coupling_wrench.x"] != 0.0
    for name, value in change.items():
        bench[name] = value
    np.testing.assert_array_equal(bench.planar("coupling_wrench"), 0.0)
    for _ in range(50):
        bench.step()
    np.testing.assert_array_equal(bench.planar("box_pose"), 0.0)


def test_fingers_of_a_device_that_is_not_active_are_not_there() -> None:
    """The sender says finger by finger whether it can be touched."""
    bench = station()
    for devices in ((11, 11), (11, 1), (15, 11), (0, 0), (3, 2)):
        sender = Bench("remote_client", [(0.0, 0.046), (0.0, -0.046)], [0.0, np.pi])
        sender.put((0.0, 0.046), (0.0, -0.046))
        for number, device in enumerate(devices, start=1):
            sender[f"finger_{number}.status"] = device
            name = f"finger_{number}_position"
            say(bench, **{name: sender[f"up.{name}"]})
        say(bench, status=sender["up.status"])
        forces = [bench[f"peer_contact_1.finger_{f}_normal_force"] > 0 for f in (1, 2)]
        assert forces == [device in {3, 11} for device in devices]


def test_a_finger_that_is_not_in_use_is_not_there() -> None:
    bench, sender = station(), Bench("remote_client", [(0.0, 0.046)])
    sender.put((0.0, 0.046))
    for name in ("finger_1_position", "finger_2_position", "status"):
        say(bench, **{name: sender[f"up.{name}"]})
    forces = [bench[f"peer_contact_1.finger_{f}_normal_force"] > 0 for f in (1, 2)]
    assert forces == [True, False]


def test_own_finger_is_limp_unless_its_device_is_active() -> None:
    bench = Bench("distributed_workstation", [(0.0, 0.05)], peers=0)
    bench.put((0.0, 0.045))
    assert bench["finger_1.normal_force"] > 0
    assert np.all(bench["finger_1.motor_torque"] != 0)
    for status in (0, 1, 2, 7, 15):
        bench["finger_1.status"] = status
        np.testing.assert_array_equal(bench["finger_1.motor_torque"], 0.0)
        assert bench["finger_1.contact_state"] == 0
    bench["finger_1.status"] = 11
    bench["finger_1.joint_angle"] = (float("nan"), 0.0)
    np.testing.assert_array_equal(bench["finger_1.motor_torque"], 0.0)
    assert np.all(np.isfinite(bench["finger_1.position"]))


def test_pull_between_copies_is_clamped() -> None:
    bench = station(coupling_force_limit=2.0, coupling_torque_limit=0.1)
    say(bench, box_x=3.0, box_y=-4.0, box_theta=1.0)
    np.testing.assert_allclose(bench.planar("coupling_wrench"), [1.2, -1.6, 0.1], rtol=1e-12)


def test_linear_predictor_moves_a_peer_on_by_its_age() -> None:
    bench = station(predictor=1, prediction_limit=20)
    say(bench, box_vx=0.3, box_omega=0.1)
    for age in (0, 1, 5, 12, 20, 35):
        seen = min(age, 20)
        if age:
            bench["peer_age[1]"] = age
        ahead = seen * T
        expected = [K * 0.3 * ahead + B * 0.3, 0.0, KR * 0.1 * ahead + BR * 0.1]
        np.testing.assert_allclose(bench.planar("coupling_wrench"), expected, rtol=0, atol=1e-12)


def test_linear_predictor_takes_the_senders_tick_where_no_age_is_given() -> None:
    bench = station(predictor=1, mass=1e9, inertia=1e9)
    for tick in range(20):
        sampled = tick - tick % 8
        say(bench, box_vx=0.2, source_tick=sampled, source_age=1)
        expected = (K * (tick - sampled + 1) * T + B) * 0.2
        assert bench["coupling_wrench.x"] == pytest.approx(expected, rel=1e-9)
        bench.step()


def test_client_fades_from_force_to_damping() -> None:
    bench = Bench("remote_client", [(0.0, 0.0)], local_damping=4.0)
    received, speed = np.array([0.7, -1.1]), np.array([0.2, 0.1])
    bench.put(-speed * T)
    bench.step()
    bench.put((0.0, 0.0))
    bench["down.finger_1_force"] = received
    for weight in (1.0, 0.6, 0.0):
        bench["peer_weight[1]"] = weight
        expected = weight * received - (1 - weight) * 4.0 * speed
        np.testing.assert_allclose(bench["finger_1.force"], expected, rtol=0, atol=1e-9)
    bench["peer_weight[1]"] = 1.0
    bench["peer_valid[1]"] = False
    np.testing.assert_allclose(bench["finger_1.force"], -4.0 * speed, rtol=0, atol=1e-9)


def test_force_is_limited_and_keeps_its_direction() -> None:
    bench = Bench("remote_client", [(0.0, 0.0)])
    bench.instance.initialise(**{"finger_1.max_force": 2.0})
    bench.put((0.0, 0.0))
    bench["down.finger_1_force"] = (6.0, -8.0)
    np.testing.assert_allclose(bench["finger_1.force"], [1.2, -1.6], rtol=1e-12)


def test_box_of_the_server_is_shown_by_its_client() -> None:
    bench = Bench("remote_client", [(0.0, 0.0)])
    bench.put((0.0, 0.0))
    bench["down.box_y"], bench["down.box_omega"] = 0.3, -0.2
    assert bench["box_pose.y"] == 0.3
    assert bench["box_velocity.theta"] == -0.2
