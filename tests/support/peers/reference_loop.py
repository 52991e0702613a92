"""An FMU alone in FMPy's low-level API, at the times at which cohaptic runs it.

A process of its own: ``python -m tests.support.peers.reference_loop FMU NUMERATOR DENOMINATOR TICKS
OUT``. Steps are the fraction (s); OUT is an ``.npz`` with a row a tick for each numeric output.
"""

from __future__ import annotations

import os
import sys
from fractions import Fraction
from typing import Any

import numpy as np

from tests.support.scratch import scratch_folder


def main() -> None:
    path, numerator, denominator, ticks, out = sys.argv[1:]
    rows = run(path, Fraction(int(numerator), int(denominator)), int(ticks))
    np.savez(out, **{name: np.array(values) for name, values in rows.items()})
    sys.stdout.flush()
    os._exit(0)  # what a library does at the end of the process is not compared


def run(path: str, step: Fraction, ticks: int) -> dict[str, list[Any]]:
    """The outputs before each step; fewer rows where the FMU asks for the end."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    description = fmpy.read_model_description(path, validate=False)
    version = description.fmiVersion[0]
    names = {
        variable.name: variable
        for variable in description.modelVariables
        if variable.causality == "output"
        and variable.type not in {"String", "Binary", "Clock"}
        and not variable.dimensions
        and not variable.clocks
    }
    fmu = (FMU2Slave if version == "2" else FMU3Slave)(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path, str(scratch_folder("test"))),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="it",
    )
    fmu.instantiate(loggingOn=False)
    stop = float(step * ticks)
    if version == "2":
        fmu.setupExperiment(startTime=0.0, stopTime=stop)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0, stopTime=stop)
    fmu.exitInitializationMode()
    rows: dict[str, list[Any]] = {name: [] for name in names}
    for tick in range(ticks):
        for name, variable in names.items():
            rows[name].append(_get(fmu, version, variable))
        try:
            done = fmu.doStep(float(tick * step), float(step))
        except Exception:
            break
        if version == "3" and done[1]:
            break
    return rows


def _get(fmu: Any, version: str, variable: Any) -> Any:
    kind = variable.type
    if kind == "Enumeration":
        kind = "Integer" if version == "2" else "Int64"
    return getattr(fmu, f"get{kind}")([variable.valueReference])[0]


if __name__ == "__main__":
    main()
