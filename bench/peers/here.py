"""Our own rows: the master, the bare C loop beside it, and the values that both end with."""

from __future__ import annotations

import tempfile
from pathlib import Path

from kernel import measure  # bench/kernel.py
from systems import System, system_of

from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario import Scenario


def last_values(written: Scenario) -> tuple[System, dict[str, float]]:
    """The system as a peer is given it, and by name the watched values that the last tick reads."""
    sink = MemorySink()
    with assemble(written) as simulation:
        found = system_of(simulation.assembly)
        simulation.run(sink)
    names = [f"{part}.{name}" for part, name, _ in found.watched]
    return found, {name: float(sink.signal(name)[-1]) for name in names}


def times(written: Scenario, *, recorded: bool) -> tuple[float, float]:
    """Processor time (s) of the master and of bare C, which writes a binary log where we record."""
    with tempfile.TemporaryDirectory() as folder:
        return measure(written, Path(folder), recorded=recorded, log=recorded)
