"""Components that do to a sweep's workers what native code may do."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable


class Deadly(Component):
    """Kills its process when ``ends`` is 1 or its gain is ``deadly``; sleeps when it is 2."""

    @property
    def variables(self) -> Sequence[Variable]:
        return [
            Variable(name="value", causality=Causality.OUTPUT, unit="1"),
            Variable(name="gain", causality=Causality.PARAMETER, start=1.0, unit="1"),
            Variable(name="ends", causality=Causality.PARAMETER, start=0.0, unit="1"),
            Variable(name="deadly", causality=Causality.PARAMETER, start=0.0, unit="1"),
        ]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self._gain, self._ends = setup.parameters["gain"], setup.parameters["ends"]
        if self._gain == setup.parameters["deadly"]:
            self._ends = 1
        self._seed, self._value = setup.seed, outputs["value"]
        counted = os.environ.get("COUNT_RUNS")
        if counted:
            with Path(counted).open("a") as file:
                file.write(f"{self._gain} {setup.seed}\n")

    def step(self, tick: int) -> None:
        if tick == 5 and self._ends == 1:
            os.kill(os.getpid(), signal.SIGSEGV)
        if tick == 5 and self._ends == 2:
            time.sleep(600)

    def evaluate(self, tick: int) -> None:
        self._value[0] = self._gain * tick + self._seed % 7


class Forgets(Deadly):
    """Remembers something from run to run, as no component should."""

    runs = 0

    def evaluate(self, tick: int) -> None:
        if tick == 0:
            type(self).runs += 1
        self._value[0] = type(self).runs


SCENARIO: dict[str, Any] = {
    "cohaptic": 1,
    "duration": 0.02,
    "components": {
        "push": {
            "fmu": "signal",
            "rate": 1024,
            "station": "a",
            "parameters": {"mode": "sine", "amplitude": 1.0, "frequency": 20.0},
        },
        "hand": {"fmu": "hand", "rate": 1024, "station": "b", "parameters": {"mass": 0.2}},
        "part": {
            "python": "tests.support.sweep.parts:Deadly",
            "rate": 1024,
            "station": "a",
            "parameters": {"gain": 1.0, "ends": 0.0},
        },
    },
    "channels": {"lan": {"between": ["a", "b"], "rate": 128, "round_trip_delay": 2, "loss": 0.2}},
    "connections": ["push.value -> hand.force via lan"],
    "expect": {"hand.position": {"max_abs_below": 10}},
}
