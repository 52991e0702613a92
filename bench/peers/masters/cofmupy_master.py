"""CoFMuPy's Jacobi master, a loop in Python over FMPy's classes; it keeps a record in lists."""

from __future__ import annotations

import time
from pathlib import Path

from cofmupy import Coordinator
from given import System, serve


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    system.need_one_rate("CoFMuPy")
    parts = [
        {
            "id": part["name"],
            "path": part["path"],
            "initialization": {name: value for name, (_, value) in part["start"].items()},
        }
        for part in system.parts
    ]
    joins = [
        {
            "source": {"id": a, "variable": x, "type": "fmu"},
            "target": [{"id": b, "variable": y, "type": "fmu"}],
        }
        for a, x, b, y, _ in system.joins
    ]
    coordinator = Coordinator()
    coordinator.start({"fmus": parts, "connections": joins, "cosim_method": "jacobi"})
    master = coordinator.master
    began = time.process_time()
    for _ in range(system.ticks - 1):
        master.do_step(system.step, record_outputs=record is not None)
    seconds = (time.process_time() - began) * system.ticks / (system.ticks - 1)
    # Its last values are those behind its last step: ours are read before it.
    return seconds, [
        master.get_variable((part, variable))[0] for part, variable, _ in system.watched
    ]


if __name__ == "__main__":
    serve(run)
