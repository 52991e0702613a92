"""The safety layer as a component, so that stability is studied with it in the loop.

In a scenario: ``safety_a1: {python: "hil.safety.component:Safety", ...}`` between the
workstation's ``finger_1.motor_torque`` and the pantograph's ``motor_torque``. It is the code that
guards hardware, not a model of it; a fault stays latched and commands zero to the end of the run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.base.document.form import plain_node, read_form
from cosim.base.errors import Location
from hil.device.contract import ZERO, Flag
from hil.safety.form import LimitsForm
from hil.safety.layer import SafetyLayer
from hil.safety.limits import Limits
from hil.setup.device_file import default


class Safety(Component):
    """From ``command[2]`` (N.m) and ``joint_angle[2]`` (rad) to ``motor_torque[2]`` (N.m).

    The limits are parameters by their names in a device file; ``preset`` chooses the geometry.
    """

    feedthrough = True

    @property
    def variables(self) -> Sequence[Variable]:
        """Signals, then one parameter a limit."""
        return [
            _pair("command", "Commanded joint torques", "N.m", Causality.INPUT),
            _pair("joint_angle", "Measured joint angles", "rad", Causality.INPUT),
            _count("sample_age", "Ticks since the measurement was new", Causality.INPUT),
            _pair("motor_torque", "Joint torques that may be sent", "N.m", Causality.OUTPUT),
            _count("flags", "What was done to the command (sum of bits)", Causality.OUTPUT),
            _count("fault", "1 once the layer wants the device in FAULT", Causality.OUTPUT),
            Variable(
                name="preset",
                type=VariableType.STRING,
                causality=Causality.PARAMETER,
                variability="fixed",
                start="quanser",
                description="Geometry and encoder: quanser or haply",
            ),
            *(
                Variable(
                    name=field.name,
                    causality=Causality.PARAMETER,
                    variability="fixed",
                    start=getattr(Limits(), field.name),
                    description=f"The limit '{field.name}' of a device file",
                )
                for field in fields(Limits)
            ),
        ]

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """Everything depends on everything of the same tick."""
        inputs = ["command", "joint_angle", "sample_age"]
        return {"motor_torque": inputs, "flags": inputs, "fault": inputs}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Make the layer.

        Raises:
            InputError: a limit is not one that a device file may have.
        """
        values: dict[str, Any] = dict(setup.parameters)
        preset = values.pop("preset", "quanser")
        file = default("mock", str(preset))
        place = Location(f"the parameters of {setup.name}", 0, 0)
        # Looser limits need no reason here: a simulation hurts nobody.
        limits = read_form(LimitsForm, plain_node(values, place), "a safety layer").given()
        numerator, denominator = setup.tick
        self._layer = SafetyLayer(
            file.limits.replaced(limits),
            file.linkage,
            tick=setup.period * numerator / denominator,
            quantum=file.quantum,
            region=file.region,
        )
        self._in, self._out = inputs, outputs
        self._period = setup.period
        self._fault = False

    def evaluate(self, tick: int) -> None:
        """What the layer would let through at this tick."""
        self._limit(self._layer.copy(), tick)

    def step(self, tick: int) -> None:
        """Commit this tick's motion, heat and ramp."""
        self._fault = self._limit(self._layer, tick)

    def _limit(self, layer: SafetyLayer, tick: int) -> bool:
        count = tick // self._period
        angle, command = self._in["joint_angle"], self._in["command"]
        seen = (float(angle[0]), float(angle[1]))
        trip = layer.observe(count, seen, int(self._in["sample_age"][0]))
        # The first command is not judged: a simulation starts in the middle of things.
        wanted = (float(command[0]), float(command[1])) if tick > 0 else ZERO
        decision = layer.limit(count, wanted)
        fault = self._fault or trip is not None or decision.trip is not None
        torque, flags = (ZERO, Flag.NONE) if fault else (decision.torque, decision.flags)
        self._out["motor_torque"][0], self._out["motor_torque"][1] = torque
        self._out["flags"][0], self._out["fault"][0] = int(flags), int(fault)
        return fault


def _pair(name: str, description: str, unit: str, causality: Causality) -> Variable:
    return Variable(
        name=name, description=description, unit=unit, causality=causality, shape=(2,), start=0.0
    )


def _count(name: str, description: str, causality: Causality) -> Variable:
    return Variable(
        name=name,
        type=VariableType.INT32,
        variability="discrete",
        description=description,
        causality=causality,
        start=0,
    )
