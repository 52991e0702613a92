"""A component that pushes: after a second of nothing, a torque that never changes again."""

from __future__ import annotations

from cosim.base.component import Causality, Component, Variable

TORQUE = (0.02, -0.01)


class Push(Component):
    """``motor_torque[2]`` (N.m)."""

    feedthrough = False

    @property
    def variables(self):
        return [
            Variable(
                name="motor_torque",
                unit="N.m",
                causality=Causality.OUTPUT,
                shape=(2,),
                start=0.0,
            )
        ]

    def initialise(self, setup, inputs, outputs) -> None:
        self._torque = outputs["motor_torque"]

    def step(self, tick: int) -> None:
        self._torque[:] = TORQUE if tick > 100 else 0.0
