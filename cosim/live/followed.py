"""The run that a page shows: found among those that go on, read from its rings, kept a little.

Every viewer takes the rows that it has not had yet from the same short memory, so that one that is
slow costs the others and the loop nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.drawn import signals_of
from cosim.base.errors import InputError
from cosim.realtime.ring import Reader, Ring
from cosim.realtime.watcher import LoopStatus, Watcher, find_feed

KEPT_SECONDS = 2.0
"""What a viewer can be behind and still lose nothing."""
POINTS = 256
"""Most values of one signal in one frame; more rows become the least and the most of each part."""

Cells = NDArray[np.float64]


class _Newest:
    """The newest rows, behind each other in memory that is filled in place."""

    def __init__(self, kept: int, cells: int) -> None:
        self._kept = kept
        self._room = np.empty((2 * kept, cells))
        self._begin = self._end = 0

    @property
    def rows(self) -> Cells:
        """At most ``kept`` of them, shape (n, cells)."""
        return self._room[self._begin : self._end]

    def clear(self) -> None:
        self._begin = self._end = 0

    def add(self, new: Cells) -> None:
        new = new[-self._kept :]
        if self._end + len(new) > len(self._room):
            stay = self.rows[max(0, self._end - self._begin + len(new) - self._kept) :].copy()
            self._room[: len(stay)] = stay
            self._begin, self._end = 0, len(stay)
        self._room[self._end : self._end + len(new)] = new
        self._end += len(new)
        self._begin = max(self._begin, self._end - self._kept)


@dataclass(slots=True)
class _Group:
    """One record group: its reader, and its newest rows from row ``first`` on."""

    name: str
    reader: Reader
    ring: Ring
    period: int
    columns: list[str]
    floats: NDArray[np.bool_]
    newest: _Newest
    first: int

    @property
    def rows(self) -> Cells:
        return self.newest.rows

    def read(self) -> None:
        new = self.reader.read()
        end = self.reader.position
        if self.first + len(self.rows) != end - len(new):
            self.newest.clear()
        self.newest.add(new)
        self.first = end - len(self.rows)

    def unseen(self, seen: int | None) -> tuple[int, int]:
        """Rows that are here for one who has had those before ``seen``; a newcomer: none yet."""
        end = self.first + len(self.rows)
        return max(end if seen is None else seen, self.first), end

    def values(self, place: int, begin: int) -> Cells:
        """A column from row ``begin`` of ``rows`` on, shape (n,)."""
        column = np.ascontiguousarray(self.rows[begin:, place])
        return column if self.floats[place] else column.view(np.int64).astype(np.float64)


class Followed:
    """A run that goes on: its content, its status, its newest values and rows."""

    def __init__(self, path: Path) -> None:
        self._watcher = Watcher(path)
        self.content = self._watcher.content
        self.rate = float(self.content["rate"])
        self.start = float(self.content["start"])
        """Model time (s) of tick 0."""
        self.scene: dict[str, Any] = self.content.get("scene") or {}
        self._groups = [self._open(group) for group in self.content["groups"]]
        self._place = {
            name: (number, place)
            for number, group in enumerate(self._groups)
            for place, name in enumerate(group.columns)
        }
        self.scene_signals = [name for name in signals_of(self.scene) if name in self._place]
        self._drawn = [self._drawn_of(number) for number in range(len(self._groups))]

    @classmethod
    def find(cls, wanted: str | None) -> Followed | None:
        """The run to show, ``None`` where none goes on."""
        try:
            return cls(find_feed(wanted))
        except (InputError, FileNotFoundError):
            return None

    @property
    def running(self) -> bool:
        """Whether it still goes on."""
        return self._watcher.running

    @property
    def lost(self) -> int:
        """Rows that came too fast for this process."""
        return sum(group.reader.lost for group in self._groups)

    def status(self) -> LoopStatus | None:
        """How the loop stands, ``None`` before the first tick."""
        return self._watcher.status()

    def told(self) -> dict[str, Any]:
        """What a page has to know of it, for JSON."""
        content = self.content
        columns = [column for group in content["groups"] for column in group["columns"]]
        return {
            "name": content["name"],
            "process": content["pid"],
            "folder": content["folder"],
            "rate": self.rate,
            "start": self.start,
            "scene": self.scene,
            "values": self.scene_signals,
            "signals": {column[0]: column[1] for column in columns},
            "about": content.get("about") or {},
        }

    def read(self) -> None:
        """Take what has come."""
        for group in self._groups:
            group.read()

    @property
    def time(self) -> float:
        """Of the newest row (s)."""
        ends = [(g.first + len(g.rows) - 1) * g.period for g in self._groups if len(g.rows)]
        return self.start + max(ends, default=0) / self.rate

    def at(self) -> dict[str, float]:
        """The newest value of each of ``scene_signals`` that there is one of."""
        found: dict[str, float] = {}
        for group, names, places in self._drawn:
            if len(group.rows):
                cells = group.rows[-1, places]
                whole = cells.view(np.int64).astype(np.float64)
                values = np.where(group.floats[places], cells, whole)
                found.update(zip(names, values.tolist(), strict=True))
        return found

    def newest(self) -> list[float | None]:
        """The same in the order of ``scene_signals``, as a page is told it."""
        at = self.at()
        return [_number(at[name]) if name in at else None for name in self.scene_signals]

    def groups(self) -> list[tuple[str, list[str], list[bool]]]:
        """Name of each record group, its signals, and which of them are no integers."""
        return [(group.name, group.columns, group.floats.tolist()) for group in self._groups]

    def rows_since(self, number: int, seen: dict[int, int]) -> tuple[int, int, Cells]:
        """Rows of a group that a viewer has not had: the first one's number, ticks a row, cells.

        Shape (n, signals), as the ring has them: integers are bits. ``seen`` is moved on.
        """
        group = self._groups[number]
        begin, end = group.unseen(seen.get(number))
        seen[number] = end
        return begin, group.period, group.rows[begin - group.first :]

    def since(self, names: list[str], seen: dict[int, int]) -> list[dict[str, Any]]:
        """Rows of these signals that a viewer has not had; ``seen`` is moved on.

        One entry a record group: times (s) and the signals' values at them.
        """
        found: list[dict[str, Any]] = []
        for number, group in enumerate(self._groups):
            wanted = [name for name in names if self._place.get(name, (-1, 0))[0] == number]
            begin, end = group.unseen(seen.get(number))
            seen[number] = end
            if not wanted or begin >= end:
                continue
            part = max(1, -(-(end - begin) // (POINTS // 2)))
            times, values = _thinned(group, wanted, begin, part)
            seconds = self.start + times * group.period / self.rate
            found.append({"g": number, "t": seconds.tolist(), "y": values})
        return found

    def close(self) -> None:
        """Let go of the rings."""
        for group in self._groups:
            group.reader.close()
        self._watcher.__exit__()

    def _drawn_of(self, number: int) -> tuple[_Group, list[str], list[int]]:
        """A group, and those of its signals that the scene has, with their places."""
        names = [name for name in self.scene_signals if self._place[name][0] == number]
        return self._groups[number], names, [self._place[name][1] for name in names]

    def _open(self, group: dict[str, Any]) -> _Group:
        ring = Ring(Path(group["ring"]), read_only=True)
        columns = group["columns"]
        kept = max(2, round(KEPT_SECONDS * self.rate / group["period"]))
        reader = Reader(ring)
        return _Group(
            group["name"],
            reader,
            ring,
            int(group["period"]),
            [column[0] for column in columns],
            np.array([bool(column[2]) for column in columns]),
            _Newest(kept, ring.cells),
            reader.position,
        )


def _thinned(
    group: _Group, names: list[str], begin: int, part: int
) -> tuple[NDArray[np.float64], dict[str, list[float | None]]]:
    """Row numbers and values; of each ``part`` rows the least and the most, where that is > 2."""
    count = group.first + len(group.rows) - begin
    offset = begin - group.first
    values: dict[str, list[float | None]] = {}
    if part <= 2:
        times = np.arange(begin, begin + count, dtype=np.float64)
        for name in names:
            column = group.values(group.columns.index(name), offset)
            values[name] = [_number(each) for each in column.tolist()]
        return times, values
    starts = np.arange(0, count, part)
    times = np.repeat(begin + starts.astype(np.float64), 2)
    times[1::2] += part / 2
    for name in names:
        column = group.values(group.columns.index(name), offset)
        pair = np.stack(
            [np.minimum.reduceat(column, starts), np.maximum.reduceat(column, starts)], axis=1
        )
        values[name] = [_number(each) for each in pair.ravel().tolist()]
    return times, values


def _number(value: float) -> float | None:
    """Six digits, which is more than a screen shows; what is no number is not drawn."""
    return float(f"{value:.6g}") if value - value == 0.0 else None
