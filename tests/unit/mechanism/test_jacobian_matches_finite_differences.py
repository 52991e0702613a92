"""The Jacobian that turns forces into torques is the derivative of the position it belongs to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance
from fmus.shared.mechanism.device import presets
from tests.support.physics.planar_oracle import preset_bar

LOW, HIGH = np.radians(86.0), {0: np.radians(199.0), 1: np.radians(180.0)}
unit = st.floats(0.0, 1.0)


@pytest.fixture(scope="module", params=[0, 1], ids=["quanser", "haply"])
def client(request: pytest.FixtureRequest) -> Instance:
    place = {"finger_1.base_x": 0.3, "finger_1.base_y": -0.2, "finger_1.base_angle": 0.7}
    instance = Instance("remote_client", fingers=1)
    instance.initialise(**{"finger_1.device": request.param, "finger_1.max_force": 10.0, **place})
    return instance


def position(client: Instance, joints: np.ndarray) -> np.ndarray:
    client["finger_1.joint_angle"] = joints
    return client["finger_1.position"]


@settings(deadline=None)
@given(a=unit, b=unit)
def test_jacobian_over_the_workspace(client: Instance, a: float, b: float) -> None:
    device = client["finger_1.device"]
    span = HIGH[device] - LOW
    joints = np.array([LOW + a * span, np.pi - LOW - b * span])
    transposed = []
    client["finger_1.joint_angle"] = joints
    for force in np.eye(2):
        client["down.finger_1_force"] = force
        transposed.append(client["finger_1.motor_torque"])
    step = 2e-5
    differences = [
        (
            8 * (position(client, joints + e) - position(client, joints - e))
            - (position(client, joints + 2 * e) - position(client, joints - 2 * e))
        )
        / (12 * step)
        for e in step * np.eye(2)
    ]
    np.testing.assert_allclose(np.array(transposed), np.array(differences).T, rtol=0, atol=1e-8)


@settings(deadline=None)
@given(a=unit, b=unit)
def test_position_is_where_both_distal_links_meet(client: Instance, a: float, b: float) -> None:
    device = client["finger_1.device"]
    span = HIGH[device] - LOW
    joints = np.array([LOW + a * span, np.pi - LOW - b * span])
    bar = preset_bar(device, (0.3, -0.2), 0.7)
    tip = bar.rotation.T @ (position(client, joints) - bar.origin)
    length = presets("GEOMETRY")["distal_length"][device]
    for elbow in bar.elbows(joints):
        assert np.linalg.norm(tip - elbow) == pytest.approx(length, abs=1e-14)
    np.testing.assert_allclose(bar.world(joints), position(client, joints), rtol=0, atol=1e-13)
