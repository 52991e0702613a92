"""What ``peers.py`` runs in the peers' environment: one system in one master, timed.

``peers_there.py PEER FMU SIZE SHAPE TICKS`` prints a JSON object with the seconds of the loop and
the positions that the last tick read.
"""

from __future__ import annotations

import ctypes
import json
import shutil
import sys
import time
from pathlib import Path

STEP = 1.0 / 1024
REFERENCES: dict[str, int] = {}


def references(path: str) -> None:
    import fmpy

    for variable in fmpy.read_model_description(path).modelVariables:
        REFERENCES[variable.name] = variable.valueReference


def with_fmpy(path: str, size: int, shape: str, ticks: int) -> tuple[float, list[float]]:
    """FMPy's classes of FMUs in a loop of Python."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    description, folder = fmpy.read_model_description(path), fmpy.extract(path)
    masses = []
    for number in range(size):
        mass = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=f"m{number}",
        )
        mass.instantiate()
        mass.setReal([REFERENCES["mass"]], [1.0])
        if number == 0:
            mass.setReal([REFERENCES["initial_position"]], [0.25])
        mass.setupExperiment(startTime=0.0, stopTime=ticks * STEP)
        mass.enterInitializationMode()
        mass.exitInitializationMode()
        masses.append(mass)
    position, force = [REFERENCES["position"]], [REFERENCES["force"]]
    positions: list[float] = []
    began = time.perf_counter()
    for tick in range(ticks):
        positions = [mass.getReal(position)[0] for mass in masses]
        for number, value in enumerate(positions):
            if number + 1 < size or shape == "ring":
                masses[(number + 1) % size].setReal(force, [value])
        for mass in masses:
            mass.doStep(tick * STEP, STEP)
    seconds = time.perf_counter() - began
    shutil.rmtree(folder, ignore_errors=True)
    return seconds, positions


def with_libcosim(path: str, size: int, shape: str, ticks: int) -> tuple[float, list[float]]:
    """libcosim's fixed-step algorithm."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=STEP * 1e9)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    indices = [
        execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name=f"m{number}"))
        for number in range(size)
    ]
    for number, index in enumerate(indices):
        execution.real_initial_value(index, REFERENCES["mass"], 1.0)
        if number == 0:
            execution.real_initial_value(index, REFERENCES["initial_position"], 0.25)
        if number + 1 < size or shape == "ring":
            execution.connect_real_variables(
                index, REFERENCES["position"], indices[(number + 1) % size], REFERENCES["force"]
            )
    # Its last values are those behind its last step: ours are read before it.
    began = time.perf_counter()
    execution.step(ticks - 1)
    seconds = (time.perf_counter() - began) * ticks / (ticks - 1)
    return seconds, [
        observer.last_real_values(index, [REFERENCES["position"]])[0] for index in indices
    ]


def with_ecos(path: str, size: int, shape: str, ticks: int) -> tuple[float, list[float]]:
    """ecos' fixed-step master; its library asks for oneTBB, which pip puts under ``lib``."""
    ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    for number in range(size):
        structure.add_model(f"m{number}", path)
        if number + 1 < size or shape == "ring":
            structure.make_real_connection(f"m{number}::position", f"m{(number + 1) % size}::force")
    given = {f"m{number}::mass": 1.0 for number in range(size)} | {"m0::initial_position": 0.25}
    structure.add_parameter_set("given", given)
    simulation = EcosSimulation(step_size=STEP, structure=structure)
    simulation.init(parameter_set="given")
    # Its values are those behind its last step: ours are read before it.
    began = time.perf_counter()
    simulation.step(ticks - 1)
    seconds = (time.perf_counter() - began) * ticks / (ticks - 1)
    return seconds, [simulation.get_real(f"m{number}::position") for number in range(size)]


def main() -> None:
    peer, path, size, shape, ticks = sys.argv[1:]
    references(path)
    run = {"fmpy": with_fmpy, "libcosim": with_libcosim, "ecos": with_ecos}[peer]
    seconds, positions = run(str(Path(path).absolute()), int(size), shape, int(ticks))
    print(json.dumps({"seconds": seconds, "positions": positions}), flush=True)


if __name__ == "__main__":
    main()
