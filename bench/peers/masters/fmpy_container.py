"""FMPy's container FMU, which steps its parts in C, driven by FMPy's classes.

Each part is unpacked anew into the container, so that thousands of them are not asked for.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmucontainer import (
    Component,
    Configuration,
    Connection,
    Variable,
    create_fmu_container,
)
from given import CannotError, System, serve

MOST = 256


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    system.need_one_rate("a container")
    if len(system.parts) > MOST:
        raise CannotError(f"it unpacks every part anew: not tried above {MOST}")
    given = [
        Variable(
            type=kind,
            variability="fixed",
            causality="parameter",
            initial="exact",
            name=f"{part['name']}.{name}",
            start=str(value),
            mapping=[(part["name"], name)],
        )
        for part in system.parts
        for name, (kind, value) in part["start"].items()
    ]
    shown = [
        Variable(
            type=kind,
            variability="continuous" if kind == "Real" else "discrete",
            causality="output",
            name=f"{part}.{variable}",
            mapping=[(part, variable)],
        )
        for part, variable, kind in system.watched
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "together.fmu"
        configuration = Configuration(
            fmiVersion="2.0",
            variables=given + shown,
            components=[Component(filename=p["path"], name=p["name"]) for p in system.parts],
            connections=[Connection(*join[:4]) for join in system.joins],
        )
        create_fmu_container(configuration, path)
        description, unpacked = fmpy.read_model_description(path), fmpy.extract(path)
    references = {v.name: v.valueReference for v in description.modelVariables}
    model = FMU2Slave(
        guid=description.guid,
        unzipDirectory=unpacked,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="together",
    )
    model.instantiate()
    model.setupExperiment(startTime=0.0, stopTime=system.ticks * system.step)
    model.enterInitializationMode()
    model.exitInitializationMode()
    # All of one type are read by one call.
    getters = [
        (get, named)
        for kind, get in (("Real", model.getReal), ("Integer", model.getInteger))
        if (named := [references[shown_one.name] for shown_one in shown if shown_one.type == kind])
    ]
    rows: list[list[float]] = []
    last: list[float] = []
    began = time.process_time()
    for tick in range(system.ticks):
        if record or tick + 1 == system.ticks:
            last = [value for get, named in getters for value in get(named)]
            rows.append(last)
        model.doStep(tick * system.step, system.step)
    return time.process_time() - began, last


if __name__ == "__main__":
    serve(run)
