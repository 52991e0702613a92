"""Python components that remember: those that can be saved, and those that cannot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable


class Counting(Component):
    """The number of its own steps: not told by the tick, so that it must be saved."""

    @property
    def variables(self) -> Sequence[Variable]:
        return [Variable(name="count", causality=Causality.OUTPUT, unit="1")]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self.count, self.steps = outputs["count"], 0.0

    def evaluate(self, tick: int) -> None:
        self.count[0] = self.steps

    def step(self, tick: int) -> None:
        self.steps = self.steps * 0.999 + 0.1


class Saved(Counting):
    def save(self) -> Any:
        return {"steps": self.steps}

    def load(self, values: Any) -> None:
        self.steps = values["steps"]


class SavesArrays(Saved):
    def save(self) -> Any:
        return {"steps": [self.count]}


class FailsToLoad(Saved):
    def load(self, values: Any) -> None:
        raise ValueError("this is not mine")


class Wandering(Saved):
    """Computes something else in every run of one process."""

    runs = 0.0

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        super().initialise(setup, inputs, outputs)
        Wandering.runs += 1.0
        self.steps = Wandering.runs
