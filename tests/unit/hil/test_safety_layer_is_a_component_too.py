"""The layer in a simulation is the layer on hardware: same commands, same torques, tick by tick."""

from __future__ import annotations

import numpy as np

from cosim.base.component import Setup
from hil.safety.component import Safety
from hil.safety.layer import SafetyLayer
from hil.safety.limits import Limits
from tests.support.hil.hil_bench import QUANSER, REST_ANGLE


def bound(**parameters):
    made = Safety()
    views = {
        v.name: np.zeros(v.shape or (1,), np.float64 if v.type.is_float else np.int64)
        for v in made.variables
    }
    setup = Setup(name="safe", parameters=parameters, tick=(1, 1024), period=1, seed=0)
    made.initialise(setup, views, views)
    views["joint_angle"][:] = REST_ANGLE
    return made, views


def test_same_torques_as_the_layer_itself_and_evaluate_is_pure():
    made, views = bound()
    layer = SafetyLayer(Limits(), QUANSER, tick=1 / 1024, quantum=2 * np.pi / 20000)
    layer.start()
    for tick in range(400):
        command = (0.1 * np.sin(tick / 9), 0.2 * np.cos(tick / 23))
        views["command"][:] = command
        shown = []
        for _ in range(3):
            made.evaluate(tick)
            shown.append(views["motor_torque"].copy())
        made.step(tick)
        layer.observe(tick, REST_ANGLE, 0)
        expected = layer.limit(tick, command if tick else (0.0, 0.0)).torque
        assert all(tuple(torque) == expected for torque in shown)
        assert tuple(views["motor_torque"]) == expected


def test_a_fault_is_latched():
    made, views = bound()
    made.step(0)
    views["command"][:] = np.nan
    made.step(1)
    views["command"][:] = 0.01
    for tick in range(2, 50):
        made.evaluate(tick)
        made.step(tick)
        assert (views["motor_torque"] == 0.0).all()
        assert views["fault"][0] == 1
