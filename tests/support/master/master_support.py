"""Scenarios from text or mappings, runs into memory."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import dedent
from typing import Any

from cosim.base.recording import MemorySink
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import Scenario, load


def scenario_of(
    folder: Path, written: str | Mapping[str, Any], sets: Sequence[str] = ()
) -> Scenario:
    """A scenario from YAML or a mapping; ``cohaptic: 1`` is added."""
    path = folder / "test.yaml"
    if isinstance(written, str):
        path.write_text("cohaptic: 1\n" + dedent(written))
    else:
        path.write_text(json.dumps({"cohaptic": 1, **written}))
    return load(path, sets=list(sets))


def run(scenario: Scenario, until: int | None = None) -> tuple[MemorySink, Simulation]:
    """Run a scenario and keep what it records."""
    sink = MemorySink()
    with assemble(scenario) as simulation:
        simulation.run(sink, until=until)
    return sink, simulation
