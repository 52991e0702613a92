"""Python components for the tests."""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType


class Growing(Component):
    """An integer that doubles every tick: 2 to the power of the tick."""

    closed = 0

    @property
    def variables(self) -> Sequence[Variable]:
        return [
            Variable(name="value", type=VariableType.INT64, causality=Causality.OUTPUT),
            Variable(name="scale", causality=Causality.PARAMETER, start=1.0, unit="1"),
        ]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self.setup = setup
        self.value = outputs["value"]

    def evaluate(self, tick: int) -> None:
        self.value[0] = 2 ** min(tick, 62)

    def close(self) -> None:
        type(self).closed += 1


class FailsInEvaluate(Growing):
    def evaluate(self, tick: int) -> None:
        self.value[0] = 1 // (7 - tick)


class FailsInStep(Growing):
    def step(self, tick: int) -> None:
        self.value[0] = 1 // (7 - tick)


class Spring(Component):
    """A spring and a damper between two bodies, as the virtual_coupler FMU computes it."""

    _INPUTS = ("position_a", "velocity_a", "position_b", "velocity_b")

    @property
    def variables(self) -> Sequence[Variable]:
        units = {"position": "m", "velocity": "m/s"}
        return [
            *(
                Variable(name=name, causality=Causality.INPUT, unit=units[name[:-2]])
                for name in self._INPUTS
            ),
            Variable(name="force", causality=Causality.OUTPUT, unit="N"),
            Variable(name="reaction", causality=Causality.OUTPUT, unit="N"),
            Variable(name="stiffness", causality=Causality.PARAMETER, unit="N/m"),
            Variable(name="damping", causality=Causality.PARAMETER, unit="N.s/m"),
        ]

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        return {"force": self._INPUTS, "reaction": self._INPUTS}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self.stiffness = setup.parameters["stiffness"]
        self.damping = setup.parameters["damping"]
        self.inputs, self.outputs = inputs, outputs

    def evaluate(self, tick: int) -> None:
        i = {name: float(cells[0]) for name, cells in self.inputs.items()}
        force = self.stiffness * (i["position_a"] - i["position_b"]) + self.damping * (
            i["velocity_a"] - i["velocity_b"]
        )
        self.outputs["force"][0] = force
        self.outputs["reaction"][0] = -force


class PressesCtrlC(Growing):
    def step(self, tick: int) -> None:
        if tick == 300:
            signal.raise_signal(signal.SIGINT)
