"""ecos' fixed-step master; its library asks for oneTBB, which pip puts under ``lib``."""

from __future__ import annotations

import ctypes
import sys
import time
from pathlib import Path

from given import System, serve

ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    structure = EcosSimulationStructure()
    given: dict[str, float | int | bool] = {}
    for part in system.parts:
        structure.add_model(part["name"], part["path"], part["every"] * system.step)
        for name, (_, value) in part["start"].items():
            given[f"{part['name']}::{name}"] = value
    join = {
        "Real": structure.make_real_connection,
        "Integer": structure.make_int_connection,
        "Boolean": structure.make_bool_connection,
    }
    for a, x, b, y, kind in system.joins:
        join[kind](f"{a}::{x}", f"{b}::{y}")
    structure.add_parameter_set("given", given)
    simulation = EcosSimulation(step_size=system.step, structure=structure)
    if record:
        simulation.add_csv_writer(f"{record}.csv", identifiers=system.prefixed)
    simulation.init(parameter_set="given")
    # Its values are those behind its last step: ours are read before it.
    began = time.process_time()
    simulation.step(system.ticks - 1)
    seconds = (time.process_time() - began) * system.ticks / (system.ticks - 1)
    return seconds, [
        (simulation.get_real if kind == "Real" else simulation.get_integer)(f"{part}::{name}")
        for part, name, kind in system.watched
    ]


if __name__ == "__main__":
    serve(run)
