"""The component that moves a device along an excitation: inertia fed forward, the rest fed back.

In a scenario it stands between a device's ``joint_angle`` and its ``motor_torque``, as
``python: "cosim.identification.excitation.controller:Excitation"``. ``cohaptic identify --plan``
writes all of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.base.errors import InputError
from cosim.identification.excitation.trajectory import Trajectory
from cosim.identification.five_bar import Array, FiveBar
from cosim.identification.regressor import PARAMETERS, inertia_matrix, torques

BANDWIDTH = 24.0
"""rad/s: slow beside the excitation, so that what it does not know stays in the measurement."""
DAMPING = 0.5
SMOOTHING = 0.2
"""Of a tick's rate in the rate that is fed back: counts would rattle."""

_LENGTHS = ("proximal", "distal", "base")
_SCALARS = {
    "proximal": ("m", "Length of the proximal links"),
    "distal": ("m", "Length of the distal links"),
    "base": ("m", "Distance of the motors"),
    "slow": ("rad", "Peak of the slow part"),
    "fast": ("rad/s2", "Peak of the fast part"),
    "seconds": ("s", "How long it excites"),
    "payload": ("kg", "Mass put on the tip for this run, known from a balance"),
}


class Excitation(Component):
    """From ``joint_angle[2]`` (rad) to ``motor_torque[2]`` (N.m)."""

    feedthrough = True

    @property
    def variables(self) -> Sequence[Variable]:
        """Signals, then the trajectory and what the device is taken to be."""
        return [
            _signal("joint_angle", "Measured joint angles", "rad", Causality.INPUT),
            _signal("motor_torque", "Joint torques along the trajectory", "N.m", Causality.OUTPUT),
            _signal("reference", "Joint angles that are aimed at", "rad", Causality.OUTPUT),
            *(_parameter(name, unit, text) for name, (unit, text) in _SCALARS.items()),
            _parameter("middle", "rad", "Joint angles in the middle", (2,)),
            _parameter(
                "values",
                None,
                "What the device is taken to be: " + ", ".join(each.name for each in PARAMETERS),
                (len(PARAMETERS),),
            ),
            Variable(
                name="seed",
                type=VariableType.INT32,
                causality=Causality.PARAMETER,
                variability="fixed",
                start=1,
                minimum=0,
                description="Of the sines' phases",
            ),
        ]

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """The torque depends on the angles of the same tick; the aim on nothing."""
        return {"motor_torque": ["joint_angle"], "reference": []}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Compute the trajectory; it starts where the first tick finds the handle.

        Raises:
            InputError: a value is missing, or is none that moves anything.
        """
        given = setup.parameters
        missing = [name for name in (*_SCALARS, "middle", "values") if name not in given]
        if missing:
            raise InputError(
                f"{setup.name} needs '{missing[0]}'; 'cohaptic identify --plan DEVICE.yaml' writes "
                "a scenario that has everything"
            )
        numerator, denominator = setup.tick
        self._tick = setup.period * numerator / denominator
        self._bar = FiveBar(**{name: float(given[name]) for name in _LENGTHS})
        middle = np.asarray(given["middle"], dtype=np.float64)
        if float(given["seconds"]) <= 0.0 or not np.all(np.isfinite(self._bar.tip(middle[None]))):
            raise InputError(
                f"{setup.name}: 'seconds' has to be above 0, and the links have to meet at 'middle'"
            )
        self._trajectory = Trajectory(
            middle=(float(middle[0]), float(middle[1])),
            slow=float(given["slow"]),
            fast=float(given["fast"]),
            seconds=float(given["seconds"]),
            seed=int(given.get("seed", 1)),
        )
        self._values = np.asarray(given["values"], dtype=np.float64)
        inertia = inertia_matrix(self._bar, middle.tolist()) @ self._values[:5]
        self._stiffness = np.diag(inertia) * BANDWIDTH**2
        self._damping = 2 * DAMPING * np.diag(inertia) * BANDWIDTH
        self._angle, self._torque = inputs["joint_angle"], outputs["motor_torque"]
        self._reference = outputs["reference"]
        self._aim: tuple[Array, Array, Array] | None = None
        self._last = self._rate = np.zeros(2)
        self._row = 0

    def evaluate(self, tick: int) -> None:
        """Aim, and the torque towards it."""
        if self._aim is None:
            self._start(np.array(self._angle, dtype=np.float64))
        assert self._aim is not None
        angle, rate, torque = (each[min(self._row, len(each) - 1)] for each in self._aim)
        seen = np.asarray(self._angle, dtype=np.float64)
        error = angle - seen
        turning = self._turning(seen)
        self._torque[:] = torque + self._stiffness * error + self._damping * (rate - turning)
        self._reference[:] = angle

    def step(self, tick: int) -> None:
        """On to the next place of the trajectory."""
        seen = np.array(self._angle, dtype=np.float64)
        self._rate, self._last = self._turning(seen), seen
        self._row += 1

    def _turning(self, seen: Array) -> Array:
        """The rate that is fed back (rad/s)."""
        return self._rate + SMOOTHING * ((seen - self._last) / self._tick - self._rate)

    def _start(self, seen: Array) -> None:
        angle, rate, acceleration = self._trajectory.sampled(seen, self._tick)
        needed = torques(self._bar, angle, rate, acceleration) @ self._values
        self._aim, self._last = (angle, rate, needed), seen


def _signal(name: str, text: str, unit: str, causality: Causality) -> Variable:
    return Variable(name=name, causality=causality, unit=unit, shape=(2,), description=text)


def _parameter(name: str, unit: str | None, text: str, shape: tuple[int, ...] = ()) -> Variable:
    return Variable(
        name=name,
        causality=Causality.PARAMETER,
        variability="fixed",
        unit=unit,
        shape=shape,
        start=0.0,
        description=text,
    )
