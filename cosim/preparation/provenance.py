"""What a run is of, for its manifest: components and files, with their digests."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from cosim.master.assembly.files import files_of
from cosim.master.run.simulation import Simulation
from cosim.record.playback import records_of


def components_of_run(simulation: Simulation) -> dict[str, dict[str, Any]]:
    """Kind and source of each component, and of an FMU what tells it from others."""
    found: dict[str, dict[str, Any]] = {}
    for name, component in simulation.scenario.components.items():
        found[name] = {"kind": str(component.kind), "source": component.source}
        fmu = simulation.assembly.participants[name].fmu
        if fmu is not None:
            found[name] |= {"fmi": fmu.version, "token": fmu.token, "sha256": fmu.sha256}
    return found


def input_files(simulation: Simulation) -> dict[str, str]:
    """SHA-256 (hex) by path of what else the numbers depend on.

    Tables, traces, device files and records played back; where there is no file, its reader says
    so.
    """
    scenario, participants = simulation.scenario, simulation.assembly.participants
    named = {*files_of(scenario, participants), *records_of(scenario)}
    return {str(file): _sha256(file) for file in sorted(named) if file.is_file()}


def _sha256(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
