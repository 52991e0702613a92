"""What other processes can watch of a paced run: rows of its status, and the recorded rows.

The loop writes into rings in shared memory; a small JSON file beside them says what is in them. Who
watches maps them read-only, so nobody can hold up or spoil the loop: a slow reader loses rows.
"""

from __future__ import annotations

import json
import os
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import fields
from operator import attrgetter
from pathlib import Path
from typing import Any, Protocol

from cosim.base.recording import RecordGroup
from cosim.base.system.room import no_room, shared_folder
from cosim.base.system.supervised import DeviceCells, Opens, Supervised
from cosim.realtime.ring import Ring

STATUS_ROWS = 128
STATUS_TICKS = 8
"""Ticks from one status row to the next: a row takes the loop some ten microseconds."""
PREFIX = "cohaptic-live-"
"""How the files that describe a run to others begin."""
LOOP_CELLS = ("tick", "late_ticks", "slipped", "worst")
DEVICE_CELLS = tuple(field.name for field in fields(DeviceCells))
"""The cells of a status row: the loop's, then those of each device."""
_values = attrgetter(*DEVICE_CELLS)


class Lateness(Protocol):
    """What the pacer counts."""

    misses: int
    slipped: int
    worst: int


class StatusWriter:
    """The loop's side: rows of how the loop and every device stand."""

    def __init__(self, ring: Ring, devices: Sequence[Supervised], lateness: Lateness) -> None:
        self._ring, self._devices, self._lateness = ring, devices, lateness
        self._row = array("d", bytes(8 * ring.cells))
        self._cells = memoryview(self._row).cast("B").cast("q")

    def write(self, tick: int) -> None:
        """Say how things stand as ``tick`` begins."""
        late, row = self._lateness, self._row
        row[0], row[1], row[2], row[3] = tick, late.misses, late.slipped, late.worst * 1e-9
        place = len(LOOP_CELLS)
        for device in self._devices:
            for value in _values(device.cells()):
                row[place] = value
                place += 1
        self._ring.put(self._cells)


class Feed:
    """The rings of one run; the command's process makes it, the loop fills it."""

    def __init__(
        self,
        name: str,
        rate: float,
        devices: Mapping[str, Opens],
        rings: Sequence[Ring] = (),
        *,
        start: float = 0.0,
    ) -> None:
        """Make the ring of the loop's status.

        Args:
            name: of the scenario.
            rate: base ticks a second.
            devices: by component.
            rings: what is recorded.
            start: model time (s) of tick 0.

        Raises:
            RunError: there is no room for it in shared memory.
        """
        cells = len(LOOP_CELLS) + len(DEVICE_CELLS) * len(devices)
        self.status = Ring.create(cells, STATUS_ROWS, what="the state of the loop and its devices")
        self.path = shared_folder() / f"{PREFIX}{os.getpid()}-{id(self):x}.json"
        self._content: dict[str, Any] = {
            "name": name,
            "pid": os.getpid(),
            "rate": rate,
            "start": start,
            "folder": None,
            "status": str(self.status.path),
            "devices": {
                name: {"states": list(component.states), "causes": list(component.causes)}
                for name, component in devices.items()
            },
            "groups": [],
        }
        self._rings = rings

    @property
    def devices(self) -> list[str]:
        """The device components, in the order of a status row."""
        return list(self._content["devices"])

    @property
    def published(self) -> bool:
        """Whether others can find it."""
        return self.path.exists()

    def publish(
        self,
        groups: Sequence[RecordGroup] = (),
        folder: Path | None = None,
        more: Mapping[str, Any] | None = None,
    ) -> None:
        """Let others find it, with what is recorded in its rings and where to, and ``more``.

        Raises:
            RunError: there is no room for it in shared memory.
        """
        self._content |= more or {}
        self._content["folder"] = None if folder is None else str(folder.resolve())
        self._content["groups"] = [
            {
                "name": group.name,
                "period": group.period,
                "ring": str(ring.path),
                "columns": [[c.name, c.unit or "", c.is_float] for c in group.columns],
            }
            for group, ring in zip(groups, self._rings, strict=True)
        ]
        part = self.path.with_suffix(".part")
        content = json.dumps(self._content).encode()
        try:
            part.write_bytes(content)
            part.replace(self.path)
        except OSError as error:
            part.unlink(missing_ok=True)
            what = "what others are told of the run"
            raise no_room(what, len(content), self.path.parent, error) from error

    def remove(self) -> None:
        """The run is over; who is attached keeps what it has seen."""
        self.path.unlink(missing_ok=True)
        self.status.remove()
