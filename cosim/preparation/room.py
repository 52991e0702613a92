"""Whether the record of a run fits where it would go."""

from __future__ import annotations

import shutil
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.system.room import in_words
from cosim.master.run.simulation import Simulation
from cosim.record.folder import RUNS
from cosim.record.layout import CELL_BYTES, rows_in

LARGE_SHARE = 0.5
"""Share of the free space from which on a record is worth a warning."""


def record_bytes(simulation: Simulation) -> int:
    """What the values and ticks of a whole run take (bytes)."""
    ticks = simulation.scenario.ticks
    return sum(
        CELL_BYTES * rows_in(ticks, group.period) * (len(group.columns) + 1)
        for group in simulation.groups
    )


def room_for_the_record(simulation: Simulation, folder: Path | None) -> list[str]:
    """A warning where the record takes much of the free space, or nothing is recorded.

    Raises:
        InputError: the record does not fit.
    """
    if not any(group.columns for group in simulation.groups):
        return ["nothing is recorded: the run leaves a summary without signals"]
    needed = record_bytes(simulation)
    place = _existing((RUNS if folder is None else folder).absolute())
    free = shutil.disk_usage(place).free
    said = f"the record takes {in_words(needed)}, and {in_words(free)} are free at {place}"
    if needed > free:
        raise InputError(f"{said}; record fewer signals, at a lower rate or for a shorter time")
    return [said] if needed > LARGE_SHARE * free else []


def _existing(folder: Path) -> Path:
    return next(path for path in (folder, *folder.parents) if path.exists())
