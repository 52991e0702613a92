"""What a run's page holds: facts and tables as text, signals packed, the scene.

A few signals come with every row, so that they can be zoomed into; of all others the least and the
greatest value of each of some thousand bins (the envelopes that the recorder keeps anyway). What
the scene moves by comes at least ``SCENE_RATE`` times a second. Equal signals are packed once.
"""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.meaning import Meaning
from cosim.record.reader import Run
from cosim.record.scene import recorded_of
from cosim.record.signals import RecordedSignal
from cosim.record.statistics import ColumnSummary
from cosim.report.page.pack import pack
from cosim.report.page.tables import used_ports

FULL = 40
"""Signals of which every row is kept ..."""
FULL_ROWS = 65536
"""... while a run is no longer than this, about a minute at 1024 Hz."""
SCENE_RATE = 120
"""Poses a second of simulated time, two for each that a screen draws."""

FIRST = (
    (Meaning.NORMAL_FORCE,),
    (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE),
    (Meaning.AXIS_POSITION, Meaning.AXIS_FORCE),
)
"""Panels that are open at first, of the users' own fingers."""


class Pages:
    """Packed arrays, each kind of content once."""

    def __init__(self) -> None:
        self.packed: list[dict[str, Any]] = []
        self._known: dict[bytes, int] = {}

    def add(self, values: NDArray[Any]) -> int:
        """The number under which a page finds these values."""
        content = np.ascontiguousarray(values)
        key = sha256(content.dtype.str.encode() + content.tobytes()).digest()
        if key not in self._known:
            self._known[key] = len(self.packed)
            self.packed.append(pack(content))
        return self._known[key]


def contents(
    run: Run, summaries: Mapping[str, ColumnSummary], scene: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Everything that the page's script draws, as JSON.

    Args:
        run: the record, open.
        summaries: statistics and envelope of each signal, by name.
        scene: what can be drawn of the run (``cosim.scene``), where there is anything.
    """
    pages = Pages()
    moving = recorded_of(scene or {}, run)
    panels = _panels(run, summaries)
    whole = _whole(run, panels, moving)
    signals = [
        _signal(run, signal, summaries[name], pages, is_whole=name in whole)
        for name, signal in run.signals.items()
    ]
    return {
        "start": float(run.start_tick / run.base_rate),
        "duration": float(run.ticks / run.base_rate),
        "signals": signals,
        "panels": panels,
        "scene": dict(scene) if scene and moving else None,
        "poses": [_pose(run, run[name], pages) for name in moving],
        "packed": pages.packed,
    }


def _signal(
    run: Run, signal: RecordedSignal, summary: ColumnSummary, pages: Pages, *, is_whole: bool
) -> dict[str, Any]:
    """A signal with its rows (``rows``), or with its envelope (``low`` and ``high``)."""
    found: dict[str, Any] = {"name": signal.name, "unit": signal.unit}
    if signal.description:
        found["description"] = signal.description
    if signal.column.items:
        found["items"] = {str(value): name for value, name in signal.column.items}
    period = signal.group.period / run.base_rate
    if is_whole:
        return found | {"period": float(period), "rows": pages.add(signal.values)}
    return found | {
        "period": float(period * summary.rows_per_bin),
        "low": pages.add(_like(signal, summary.lows)),
        "high": pages.add(_like(signal, summary.highs)),
    }


def _like(signal: RecordedSignal, ends: NDArray[np.float64]) -> NDArray[Any]:
    """Ends of bins in the signal's own kind, so that whole numbers stay whole."""
    return ends if signal.is_float or not np.isfinite(ends).all() else ends.astype(np.int64)


def _pose(run: Run, signal: RecordedSignal, pages: Pages) -> dict[str, Any]:
    """A signal that the scene moves by, every ``stride``-th row of it."""
    rate = float(signal.group.rate)
    stride = max(1, int(rate // SCENE_RATE), -(-signal.group.rows // FULL_ROWS))
    period = float(signal.group.period / run.base_rate) * stride
    return {"name": signal.name, "period": period, "rows": pages.add(signal[::stride])}


def _whole(run: Run, panels: list[dict[str, Any]], moving: list[str]) -> set[str]:
    """The signals of which every row is kept: what is looked at first, then what moves."""
    first = [name for panel in panels for name in panel["signals"]]
    wanted = dict.fromkeys([*first, *moving, *run.signals])
    short = [name for name in wanted if run[name].group.rows <= FULL_ROWS]
    return {*short[:FULL]}


def _panels(run: Run, summaries: Mapping[str, ColumnSummary]) -> list[dict[str, Any]]:
    """Plots that are open at first: signals of one unit each."""
    panels: list[dict[str, Any]] = []
    for meanings in FIRST:
        units: dict[str, list[str]] = {}
        for name, signal in run.signals.items():
            if signal.meaning in meanings and signal.belongs_to.peer is None:
                units.setdefault(signal.unit, []).append(name)
        panels += [{"unit": unit, "signals": names[:8]} for unit, names in units.items()]
    energies = used_ports(run, summaries)
    if energies:
        panels.append({"unit": "J", "signals": energies[:8]})
    if not panels:
        by_unit: dict[str, list[str]] = {}
        for name, signal in run.signals.items():
            by_unit.setdefault(signal.unit, []).append(name)
        panels = [{"unit": unit, "signals": names[:4]} for unit, names in by_unit.items()][:4]
    return panels
