"""A paced run as another process sees it: its newest status, and the rows that it records.

Everything is mapped read-only (``cosim.realtime.live`` says what is there); what comes too fast is
lost and counted.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.system.room import shared_folder
from cosim.base.system.supervised import DeviceCells
from cosim.realtime.live import DEVICE_CELLS, LOOP_CELLS, PREFIX
from cosim.realtime.ring import Reader, Ring

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceStatus:
    """One device as the loop last told of it: rad, N.m, and the force at its tip (N)."""

    name: str
    state: str
    output: bool
    """Whether it is allowed to push."""
    age: int
    joint_angle: Pair
    torque: Pair
    force: Pair
    flags: int
    cause: str | None
    """Why it is in fault."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopStatus:
    """The newest row."""

    tick: int
    time: float
    """Of the scenario (s)."""
    misses: int
    slipped: int
    worst: float
    """Longest lateness (s)."""
    devices: tuple[DeviceStatus, ...]

    def line(self) -> str:
        """One line for a console."""
        parts = [
            f"t {self.time:.1f} s",
            f"tick {self.tick}",
            f"{self.misses} missed (worst {self.worst * 1e3:.2f} ms late)",
        ]
        for device in self.devices:
            size = float(np.hypot(*device.force))
            text = f"{device.name} {device.state} {size:.2f} N age {device.age}"
            if not device.output and device.state == "active":
                text += " dry"
            if device.cause is not None:
                text += f" FAULT: {device.cause}"
            parts.append(text)
        return " | ".join(parts)


@dataclass(frozen=True, slots=True)
class _Columns:
    """Signals of one record group that are watched."""

    reader: Reader
    names: list[str]
    places: list[int]
    floats: list[bool]


class Watcher:
    """A run as another process sees it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.content: dict[str, Any] = json.loads(path.read_text("utf-8"))
        self._status = Ring(Path(self.content["status"]), read_only=True)
        self._readers: list[_Columns] = []

    @property
    def running(self) -> bool:
        """Whether the run is still there."""
        return self._path.exists() and _is_alive(int(self.content["pid"]))

    def status(self) -> LoopStatus | None:
        """The newest row, ``None`` before the first tick."""
        row = self._status.newest()
        if row is None:
            return None
        devices: list[DeviceStatus] = []
        for index, (name, words) in enumerate(self.content["devices"].items()):
            begin = len(LOOP_CELLS) + index * len(DEVICE_CELLS)
            cells = DeviceCells(*row[begin : begin + len(DEVICE_CELLS)].tolist())
            devices.append(
                DeviceStatus(
                    name=name,
                    state=words["states"][int(cells.state)],
                    output=bool(cells.output),
                    age=int(cells.age),
                    joint_angle=(cells.angle_1, cells.angle_2),
                    torque=(cells.torque_1, cells.torque_2),
                    force=(cells.force_1, cells.force_2),
                    flags=int(cells.flags),
                    cause=None if cells.cause < 0 else words["causes"][int(cells.cause)],
                )
            )
        return LoopStatus(
            tick=int(row[0]),
            time=float(self.content["start"]) + float(row[0]) / float(self.content["rate"]),
            misses=int(row[1]),
            slipped=int(row[2]),
            worst=float(row[3]),
            devices=tuple(devices),
        )

    def signals(self) -> dict[str, str]:
        """Recorded signals that can be watched, with their units."""
        return {
            column[0]: column[1] for group in self.content["groups"] for column in group["columns"]
        }

    def watch(self, names: Sequence[str]) -> None:
        """Begin to read these signals."""
        for group in self.content["groups"]:
            columns = [column[0] for column in group["columns"]]
            wanted = [name for name in names if name in columns]
            if wanted:
                places = [columns.index(name) for name in wanted]
                floats = [bool(group["columns"][place][2]) for place in places]
                reader = Reader(Ring(Path(group["ring"]), read_only=True))
                self._readers.append(_Columns(reader, wanted, places, floats))

    def rows(self) -> dict[str, NDArray[np.float64]]:
        """What has come since the last call: shape (n,) a signal."""
        found: dict[str, NDArray[np.float64]] = {}
        for group in self._readers:
            cells = group.reader.read()
            for name, place, is_float in zip(group.names, group.places, group.floats, strict=True):
                column = np.ascontiguousarray(cells[:, place])
                found[name] = column if is_float else column.view(np.int64).astype(float)
        return found

    @property
    def lost(self) -> int:
        """Rows that were overwritten before they were read."""
        return sum(group.reader.lost for group in self._readers)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for group in self._readers:
            group.reader.close()
        self._status.close()


def find_feed(wanted: str | None) -> Path:
    """The run to watch: by its folder, scenario or process number; the newest one by default.

    Raises:
        InputError: there is none.
    """
    live: dict[Path, dict[str, Any]] = {}
    for path in shared_folder().glob(f"{PREFIX}*.json"):
        with contextlib.suppress(OSError, ValueError):
            content = json.loads(path.read_text("utf-8"))
            if _is_alive(int(content["pid"])):
                live[path] = content
    for path in sorted(live, key=lambda path: path.stat().st_mtime, reverse=True):
        content = live[path]
        known = {str(path), content["name"], str(content["pid"]), str(content.get("starter"))}
        folder = content["folder"]
        at = wanted is not None and folder is not None and str(Path(wanted).resolve()) == folder
        if wanted is None or wanted in known or at:
            return path
    names = ", ".join(f"{content['name']} ({content['pid']})" for content in live.values())
    there = f"there are {names}" if names else "no paced run is going on"
    missing = "there is nothing to watch" if wanted is None else f"{wanted} is not running"
    raise InputError(
        f"{missing}: {there}; 'cohaptic run --realtime' and 'cohaptic station' can be watched"
    )


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
