"""What a run depends on, as a digest: of equal content a run need not be repeated."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.system.installed import version_of
from cosim.master.assembly.assemble import Assembly, put_together
from cosim.master.assembly.files import files_of
from cosim.record.playback import KINDS, records_of
from cosim.scenario import Scenario
from cosim.scenario.resolved import to_document
from cosim.sweep.job import Job, override
from cosim.sweep.planning.axis import Value, is_word
from cosim.sweep.work.variants import build


class Contents:
    """The keys of a sweep's points: two points have one key where their runs are the same.

    A key has the scenario as it is written, without what is varied, and every place with its value;
    a word may name a file, so what it stands for is read, once for each.
    """

    def __init__(self, job: Job, first: Assembly) -> None:
        """``first`` stands in for the scenario where that cannot run with no point's values."""
        self._job = job
        self._first = first
        self._structures: dict[tuple[Value | None, ...], str] = {}

    @property
    def structure(self) -> str:
        """SHA-256 (hex) of all that points without words have in common."""
        return self._structure(tuple(None for _ in self._job.axes))

    def key(self, point: Sequence[Value]) -> str:
        """SHA-256 (hex) of a point's content."""
        structure = self._structure(tuple(value if is_word(value) else None for value in point))
        values = {
            place: value
            for axis, value in zip(self._job.axes, point, strict=True)
            for place in axis.places
        }
        text = json.dumps([structure, sorted(values.items())])
        return hashlib.sha256(text.encode()).hexdigest()

    def _structure(self, words: tuple[Value | None, ...]) -> str:
        if words not in self._structures:
            self._structures[words] = self._read(words)
        return self._structures[words]

    def _read(self, words: tuple[Value | None, ...]) -> str:
        """What the words stand for; where they cannot be used, why: tomorrow they may be."""
        sets = [
            override(place, value)
            for axis, value in zip(self._job.axes, words, strict=True)
            if value is not None
            for place in axis.places
        ]
        try:
            return structure_of(self._job, _assembly(build(self._job.written, sets)))
        except InputError as error:
            if not sets:
                return structure_of(self._job, self._first)
            text = f"{self.structure}\n{error}"
            return hashlib.sha256(text.encode()).hexdigest()


def structure_of(job: Job, assembly: Assembly) -> str:
    """SHA-256 (hex) of what the runs of an assembly have in common.

    The resolved scenario, the FMUs, every other file that it names, the classes of Python
    components, what is looked at, and the version of what computes it.
    """
    state = hashlib.sha256()
    scenario = assembly.scenario
    for part in (version_of("cohaptic"), to_document(scenario), job.readings, job.start):
        state.update(json.dumps(part, sort_keys=True, default=str).encode() + b"\n")
    for name, participant in assembly.participants.items():
        if participant.fmu is not None:
            state.update(f"{name} {participant.fmu.sha256}\n".encode())
    for file in _files(assembly):
        state.update(f"{file} {_digest(file)}\n".encode())
    return state.hexdigest()


def _assembly(scenario: Scenario) -> Assembly:
    return put_together(scenario, kinds=KINDS)


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
