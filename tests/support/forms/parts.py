"""The smallest components that show what a scenario asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cosim.base.component import Causality, Cells, Component, Setup, Variable


class Ramp(Component):
    """``x`` is the number of its step, times ``gain``."""

    @property
    def variables(self) -> Sequence[Variable]:
        return [
            Variable(name="x", causality=Causality.OUTPUT),
            Variable(name="gain", causality=Causality.PARAMETER, variability="fixed", start=1.0),
        ]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self._x, self._period = outputs["x"], setup.period
        self._gain = float(setup.parameters.get("gain", 1.0))

    def evaluate(self, tick: int) -> None:
        self._x[0] = (100.0 + tick) * self._gain


class Follow(Component):
    """``y`` is ``u`` of the same tick."""

    @property
    def variables(self) -> Sequence[Variable]:
        return [
            Variable(name="u", causality=Causality.INPUT, start=0.0),
            Variable(name="y", causality=Causality.OUTPUT),
        ]

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        return {"y": ["u"]}

    feedthrough = True

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self._u, self._y = inputs["u"], outputs["y"]

    def evaluate(self, tick: int) -> None:
        self._y[0] = self._u[0]


class Twice(Follow):
    """``y`` is twice ``u``."""

    def evaluate(self, tick: int) -> None:
        self._y[0] = 2 * self._u[0]
