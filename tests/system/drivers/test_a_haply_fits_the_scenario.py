"""two_users_box on a Haply: the finger's path is in its workspace, the forces within its motors."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest

from cosim.run import run_scenario
from cosim.scenario import load
from fmus.shared.mechanism.device import presets
from hil.setup.device_file import default

DEVICES = "scenarios/devices"
MARGIN = 0.01
"""Room that is left around the path (m)."""


@pytest.fixture(scope="module")
def simulated():
    return load("two_users_box", [f"{DEVICES}/haply_finger.yaml"])


def place(parameters):
    return [parameters[name] for name in ("device", "base_x", "base_y", "base_angle")]


def test_device_and_workstation_stand_at_the_same_place(simulated):
    on_the_bench = load("two_users_box", [f"{DEVICES}/haply.yaml"])
    workstation = simulated.components["vr_a"].parameters
    finger = [workstation[f"finger_1.{n}"] for n in ("device", "base_x", "base_y", "base_angle")]
    assert finger == place(simulated.components["finger_a1"].parameters)
    real = on_the_bench.components["vr_a"].parameters
    assert {n: v for n, v in real.items() if n.startswith("finger_1.")} == {
        n: v for n, v in workstation.items() if n.startswith("finger_1.")
    }


def test_the_device_file_has_the_model_s_geometry():
    linkage = default("haply").linkage
    model = {name: haply for name, (_, haply) in presets("GEOMETRY").items()}
    assert linkage.proximal == model["proximal_length"]
    assert linkage.distal == model["distal_length"]
    assert linkage.base == model["base_distance"]


def path(scenario):
    """Everywhere the operator means to be, in the device's frame (m)."""
    operator = load("two_users_box").components["operator_a1"].parameters
    count = operator["via_count"]
    vias = zip(operator["via_x"][:count], operator["via_y"][:count], strict=True)
    corners = [operator["initial_position"], *vias]
    x, y = ([corner[axis] for corner in corners] for axis in (0, 1))
    _, base_x, base_y, angle = place(scenario.components["finger_a1"].parameters)
    for wx in np.linspace(min(x) - MARGIN, max(x) + MARGIN, 9):
        for wy in np.linspace(min(y) - MARGIN, max(y) + MARGIN, 9):
            dx, dy = wx - base_x, wy - base_y
            yield dx * cos(angle) + dy * sin(angle), dy * cos(angle) - dx * sin(angle)


def test_the_whole_path_lies_inside_the_workspace_and_the_motors_can_push_there(simulated):
    file = default("haply")
    region = file.linkage.default_region()
    force = simulated.components["vr_a"].parameters["finger_1.max_force"]
    for tip in path(simulated):
        angle = file.linkage.angles(tip)
        assert region.contains(tip)
        assert file.linkage.dexterity(angle, tip) >= file.limits.dexterity
        columns = [file.linkage.tip_force(angle, torque) for torque in ((1.0, 0.0), (0.0, 1.0))]
        back = np.linalg.inv(np.array(columns).T)
        for turn in np.arange(0, 2 * pi, pi / 8):
            torque = back @ (force * np.array([cos(turn), sin(turn)]))
            assert np.abs(torque).max() <= file.limits.torque, (tip, hypot(*torque))


def test_the_grasp_holds_with_a_finger_of_that_size(simulated, tmp_path):
    finished = run_scenario(simulated, tmp_path / "run", figure=False)
    assert finished.summary.status == 0, finished.summary.text()
