"""Which way each motor pushes: a tiny torque that grows until its joint moves, one after the other.

A component between a device's ``joint_angle`` and its ``motor_torque``, so that the check runs as
any other paced run does: safety layer, supervisor, permission and all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType

LARGEST = 0.04
"""Torque at which the probe gives up (N.m): some 0.4 N at the handle."""
GROWTH = 0.03
"""How fast it grows (N.m/s)."""
ENOUGH = 0.015
"""A joint that turned so far (rad) has moved."""
WAIT = 2.5
"""Seconds until the ramp after activation is over."""
REST = 0.6
"""Seconds without torque before each push."""
SECONDS = WAIT + 2 * (REST + LARGEST / GROWTH) + REST
"""How long the whole of it takes."""


class SignProbe(Component):
    """``moved[2]``: 1 where the joint went the way it was pushed, -1 the other, 0: not at all."""

    feedthrough = False

    @property
    def variables(self) -> Sequence[Variable]:
        """Angles in, torques and verdicts out."""
        return [
            _pair("joint_angle", "rad", Causality.INPUT),
            _pair("motor_torque", "N.m", Causality.OUTPUT),
            Variable(
                name="moved",
                type=VariableType.INT32,
                variability="discrete",
                causality=Causality.OUTPUT,
                shape=(2,),
                start=0,
                description="Which way each joint went when it was pushed",
            ),
        ]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Begin with rest."""
        numerator, denominator = setup.tick
        self._tick = setup.period * numerator / denominator
        self._angle, self._torque = inputs["joint_angle"], outputs["motor_torque"]
        self._moved = outputs["moved"]
        self._torque[:], self._moved[:] = 0.0, 0
        self._joint, self._begin = 0, 0.0
        self._time, self._left = 0.0, WAIT

    def step(self, tick: int) -> None:
        """Rest, then push the joint whose turn it is."""
        self._torque[:] = 0.0
        if self._joint > 1:
            return
        angle = float(self._angle[self._joint])
        self._time += self._tick
        pushed = (self._time - self._left - REST) * GROWTH
        if pushed <= 0.0:
            self._begin = angle
            return
        turned = angle - self._begin
        if abs(turned) > ENOUGH:
            self._moved[self._joint] = 1 if turned > 0 else -1
        if abs(turned) > ENOUGH or pushed > LARGEST:
            self._joint, self._left = self._joint + 1, self._time
            return
        self._torque[self._joint] = pushed


def _pair(name: str, unit: str, causality: Causality) -> Variable:
    return Variable(
        name=name,
        unit=unit,
        causality=causality,
        shape=(2,),
        start=0.0,
        description=f"Of both joints ({unit})",
    )
