"""What a run depends on, as a digest: of equal content a run need not be repeated."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.files import files_of
from cosim.record.playback import records_of
from cosim.scenario.resolved import to_document
from cosim.sweep.job import Job
from cosim.sweep.planning.axis import Value


def structure_of(job: Job, assembly: Assembly) -> str:
    """SHA-256 (hex) of all that the points have in common.

    The resolved scenario, the FMUs, every other file that it names, the classes of Python
    components, and what is looked at.
    """
    state = hashlib.sha256()
    scenario = assembly.scenario
    for part in (to_document(scenario), job.readings, job.start):
        state.update(json.dumps(part, sort_keys=True, default=str).encode() + b"\n")
    for name, participant in assembly.participants.items():
        if participant.fmu is not None:
            state.update(f"{name} {participant.fmu.sha256}\n".encode())
    for file in _files(assembly):
        state.update(f"{file} {_digest(file)}\n".encode())
    return state.hexdigest()


def key_of(structure: str, job: Job, point: Sequence[Value]) -> str:
    """SHA-256 (hex) of a point's content: the common structure, and every place with its value."""
    values = {
        place: value for axis, value in zip(job.axes, point, strict=True) for place in axis.places
    }
    text = json.dumps([structure, sorted(values.items())])
    return hashlib.sha256(text.encode()).hexdigest()


def _files(assembly: Assembly) -> list[Path]:
    """Files that the numbers depend on, besides the FMUs."""
    scenario, participants = assembly.scenario, assembly.participants
    found = {*files_of(scenario, participants), *records_of(scenario)}
    for participant in participants.values():
        if participant.component is not None:
            module = sys.modules[type(participant.component).__module__]
            found |= {Path(module.__file__)} if module.__file__ else set()
    return sorted(file for file in found if file.is_file())


def _digest(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
