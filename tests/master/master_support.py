"""Scenarios from text, runs into memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import dedent

from cosim.master.recording import MemorySink
from cosim.master.simulation import Simulation, assemble
from cosim.scenario import Scenario, load


def scenario_of(folder: Path, text: str, sets: Sequence[str] = ()) -> Scenario:
    """A scenario from YAML; the first line ``cohaptic: 1`` is added."""
    path = folder / "test.yaml"
    path.write_text("cohaptic: 1\n" + dedent(text))
    return load(path, sets=list(sets))


def run(scenario: Scenario, until: int | None = None) -> tuple[MemorySink, Simulation]:
    """Run a scenario and keep what it records."""
    sink = MemorySink()
    with assemble(scenario) as simulation:
        simulation.run(sink, until=until)
    return sink, simulation
