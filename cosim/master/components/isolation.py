"""Which FMUs get a process of their own: those asked to, and those that cannot do without.

Two instances of an FMU that exists once in a process; FMUs that bring libraries of one name and
different contents, of which the system would load the first one for all; and FMUs that need a tool
beside them, whose crash is not theirs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from cosim.master.components.participant import Participant
from cosim.master.fmu.archive import sha256_of
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.binary import find_binary
from cosim.scenario import Scenario


def isolate(participants: Mapping[str, Participant], scenario: Scenario) -> list[str]:
    """Mark those that get a process of their own; a note for each that was not asked to."""
    fmus = {name: each.fmu for name, each in participants.items() if each.fmu is not None}
    count = Counter(fmu.sha256 for fmu in fmus.values())
    clashing = _clashing(fmus)
    notes: list[str] = []
    for name, fmu in fmus.items():
        reason = ""
        if fmu.once_per_process and count[fmu.sha256] > 1:
            reason = "its FMU can be instantiated only once in a process"
        elif fmu.sha256 in clashing:
            reason = f"another FMU brings another library of the name {clashing[fmu.sha256]}"
        elif fmu.needs_tool:
            reason = "its FMU needs a tool beside it (needsExecutionTool)"
        asked = scenario.components[name].is_isolated
        participants[name].is_isolated = asked or bool(reason)
        if reason and not asked:
            notes.append(f"{name} has a process of its own: {reason}")
    return notes


def _clashing(fmus: Mapping[str, FmuDescription]) -> dict[str, str]:
    """The digests of FMUs with a library that shares its name alone with another FMU's."""
    if len(fmus) < 2:
        return {}
    by_name: dict[str, dict[str, Path]] = {}
    for fmu in {fmu.sha256: fmu for fmu in fmus.values()}.values():
        own = find_binary(fmu)
        for file in own.parent.iterdir():
            if file != own and file.is_file():
                by_name.setdefault(file.name, {})[fmu.sha256] = file
    return {
        digest: name
        for name, files in by_name.items()
        if len(files) > 1 and _differ(list(files.values()))
        for digest in files
    }


def _differ(files: list[Path]) -> bool:
    return len({sha256_of(file) for file in files}) > 1
