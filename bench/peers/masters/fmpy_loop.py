"""FMPy's classes of FMUs in a loop of Python; a record is a list of lists."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave
from given import System, serve


class Models:
    """Instances by name, of FMUs that are unpacked once."""

    def __init__(self, system: System) -> None:
        self.references: dict[str, dict[str, int]] = {}
        self.instances: dict[str, Any] = {}
        unpacked: dict[str, Any] = {}
        for part in system.parts:
            path = part["path"]
            if path not in unpacked:
                unpacked[path] = fmpy.read_model_description(path), fmpy.extract(path)
            description, folder = unpacked[path]
            references = {v.name: v.valueReference for v in description.modelVariables}
            model = FMU2Slave(
                guid=description.guid,
                unzipDirectory=folder,
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName=part["name"],
            )
            model.instantiate()
            for name, (kind, value) in part["start"].items():
                getattr(model, f"set{kind}")([references[name]], [value])
            model.setupExperiment(startTime=0.0, stopTime=system.ticks * system.step)
            model.enterInitializationMode()
            self.references[part["name"]], self.instances[part["name"]] = references, model
        for model in self.instances.values():
            model.exitInitializationMode()

    def reference(self, part: str, variable: str) -> list[int]:
        return [self.references[part][variable]]


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    models = Models(system)
    every = {part["name"]: part["every"] for part in system.parts}
    joins = [
        (
            getattr(models.instances[a], f"get{kind}"),
            models.reference(a, x),
            getattr(models.instances[b], f"set{kind}"),
            models.reference(b, y),
            every[a],
        )
        for a, x, b, y, kind in system.joins
    ]
    watched = [
        (
            getattr(models.instances[part], f"get{kind}"),
            models.reference(part, variable),
            every[part],
        )
        for part, variable, kind in system.watched
    ]
    steps = [(models.instances[name], each) for name, each in every.items()]
    rows: list[list[float]] = []
    began = time.process_time()
    handed: list[list[float]] = [[] for _ in joins]
    last = [0.0] * len(watched)
    for tick in range(system.ticks):
        # What a slow part has stepped to does not hold before the end of its step.
        for number, (get, reference, _, _, each) in enumerate(joins):
            if tick % each == 0:
                handed[number] = get(reference)
        for (_, _, give, reference, _), value in zip(joins, handed, strict=True):
            give(reference, value)
        if record or tick + system.slowest >= system.ticks:
            for number, (get, reference, each) in enumerate(watched):
                if tick % each == 0:
                    last[number] = get(reference)[0]
            rows.append(last[:])
        for model, each in steps:
            if tick % each == 0:
                model.doStep(tick * system.step, each * system.step)
    return time.process_time() - began, last


if __name__ == "__main__":
    serve(run)
