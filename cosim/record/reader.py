"""Reading a run folder: groups of signals with their ticks, loaded when they are asked for.

A run that was killed, or that still goes on, reads like any other: what counts is the number of
complete rows in each group.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache, cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.recording import RecordGroup
from cosim.base.suggest import did_you_mean
from cosim.record.hdf5 import h5py
from cosim.record.layout import FORMAT_VERSION
from cosim.record.signals import RecordedSignal, RecordTimes, SignalGroup, Signals
from cosim.record.stores import FileStore, GroupStore
from cosim.record.texts.journal import read_texts
from cosim.record.texts.recorded import RecordedText

RUN_FILE = "run.h5"


MANIFEST_FILE = "manifest.json"


SCENARIO_FILE = "scenario.resolved.yaml"


READABLE = range(1, FORMAT_VERSION + 1)
"""The formats of run.h5 that are read."""


class Run:
    """A run folder that is open for reading; a context manager."""

    def __init__(
        self,
        folder: Path,
        stores: Mapping[str, GroupStore],
        base_rate: Fraction,
        manifest: Mapping[str, Any],
        close: Callable[[], object],
        *,
        start_tick: int = 0,
    ) -> None:
        self.folder = folder
        self.manifest: Mapping[str, Any] = manifest
        """What ran, where, and how it ended; see docs/record.md. Empty where there is none."""
        self._close = close
        self._times = RecordTimes(base_rate, start_tick)
        self.base_rate = base_rate
        """Base ticks a second (Hz)."""
        self.start_tick = start_tick
        """How many base ticks after time 0 the first one is."""
        self.groups: Mapping[str, SignalGroup] = MappingProxyType(
            {name: SignalGroup(self._times, name, store) for name, store in stores.items()}
        )

    @cached_property
    def signals(self) -> Mapping[str, RecordedSignal]:
        """Every signal by name; of one recorded at several rates, the fastest."""
        slowest_first = sorted(self.groups.values(), key=lambda group: -group.period)
        groups: dict[str, SignalGroup] = {}
        for group in slowest_first:
            groups.update(dict.fromkeys(group.signals, group))
        return Signals(groups, lambda name: groups[name].signals[name])

    @cached_property
    def texts(self) -> Mapping[str, RecordedText]:
        """Every String and Binary by name; of one recorded at several rates, the fastest."""
        found: dict[str, RecordedText] = {}
        for group in sorted(self.groups.values(), key=lambda group: -group.period):
            found.update(group.texts)
        return MappingProxyType(found)

    @property
    def record_groups(self) -> tuple[RecordGroup, ...]:
        """What was recorded together, as the recorder was told."""
        return tuple(
            RecordGroup(
                name=name,
                period=group.period,
                columns=tuple(signal.column for signal in group.signals.values()),
            )
            for name, group in self.groups.items()
        )

    def __getitem__(self, name: str) -> RecordedSignal:
        """One signal of numbers; texts are in ``texts``.

        Raises:
            InputError: nothing of that name was recorded; says what comes near.
        """
        if name in self.signals:
            return self.signals[name]
        if name in self.texts:
            raise InputError(
                f"{self.folder}: {name} is a text, of which the changes are recorded: texts[{name}]"
                " of the run has them."
            )
        raise InputError(
            f"{self.folder}: no signal {name} was recorded.{did_you_mean(str(name), self.signals)}"
        )

    def __contains__(self, name: object) -> bool:
        return name in self.signals

    def seconds(self, ticks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Times (s) of base ticks: one division by the base rate, so rounded once."""
        return self._times.seconds(ticks)

    @property
    def span(self) -> tuple[float, float]:
        """The times of the first tick and of the record's end (s)."""
        first, end = self.start_tick, self.start_tick + self.ticks
        return float(first / self.base_rate), float(end / self.base_rate)

    @cached_property
    def ticks(self) -> int:
        """Base ticks that the record covers completely in every group; of none, those that ran."""
        ending: Mapping[str, Any] = self.manifest.get("exit") or {}
        ran = int(ending.get("ticks", 0))
        return min((group.rows * group.period for group in self.groups.values()), default=ran)

    @property
    def scenario_yaml(self) -> str:
        """The resolved scenario that ran; empty where the folder has none."""
        path = self.folder / SCENARIO_FILE
        return path.read_text(encoding="utf-8") if path.exists() else ""

    @property
    def scenario_file(self) -> Path:
        """Where the resolved scenario that ran is written.

        Raises:
            InputError: the folder has none.
        """
        if not self.scenario_yaml:
            raise InputError(
                f"{self.folder} has no {SCENARIO_FILE}, so that nobody knows what ran."
            )
        return self.folder / SCENARIO_FILE

    def to_dataframe(self, *patterns: str) -> Any:
        """A pandas table: a row a time (s), a column a signal, slower signals held.

        Names, and patterns with ``*`` and ``?``, choose signals. ``attrs["units"]`` has the units.

        Raises:
            InputError: a pattern matches nothing, or pandas is not installed.
        """
        return _labelled().to_dataframe(self, patterns)

    def to_xarray(self, *patterns: str) -> Any:
        """An xarray dataset: each signal over its own times (s), with unit and description.

        Raises:
            InputError: a pattern matches nothing, or xarray is not installed.
        """
        return _labelled().to_xarray(self, patterns)

    def plot(
        self,
        *patterns: str,
        kind: str = "time",
        start: str | float = 0,
        until: str | float | None = None,
        file: str | Path | None = None,
    ) -> Any:
        """Draw signals into ``plot.png`` of the folder, or into ``file`` (png, svg or pdf).

        Names, and patterns with ``*`` and ``?``, choose signals; ``kind`` is ``time``,
        ``difference``, ``spectrum``, ``phase`` or ``histogram``; times are in s. A notebook shows
        what is returned, which has the ``file``.

        Raises:
            InputError: no such kind, signal or time, or the file cannot be written.
        """
        place = self.folder / "plot.png" if file is None else Path(file)
        picture = importlib.import_module("cosim.plot.picture")
        return picture.picture_of([self], patterns, kind, (start, until), place)

    def show(self) -> Path:
        """Open the run's page in the browser.

        Raises:
            InputError: the run has none.
        """
        page = self.folder / "report.html"
        if not page.is_file():
            raise InputError(f"{self.folder}: there is no report.html: run it with its page.")
        webbrowser = importlib.import_module("webbrowser")
        webbrowser.open(page.resolve().as_uri())
        return page

    def __repr__(self) -> str:
        return str(_labelled().outline(self))

    def _repr_html_(self) -> str:
        return str(_labelled().outline_html(self))

    def close(self) -> None:
        """Close the file; signals cannot be read afterwards."""
        self._close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _labelled() -> Any:
    """What shows a run to people; it stands above this module, which knows it by name alone."""
    return importlib.import_module("cosim.record.labelled")


def open_run(path: str | Path, *, file: Path | None = None) -> Run:
    """Open a run folder (or the ``run.h5`` in it) for reading; ``file`` in place of the latter.

    Raises:
        InputError: there is no run, or its file was not written by cohaptic.
    """
    folder = Path(path)
    if folder.name == RUN_FILE:
        folder = folder.parent
    target = file or folder / RUN_FILE
    if not target.is_file():
        raise InputError(f"{folder}: not a run folder: there is no {RUN_FILE} in it.")
    try:
        opened = h5py().File(target, "r", locking=False, rdcc_nbytes=0)
    except OSError as error:
        raise InputError(f"{target}: not a readable HDF5 file ({error}).") from error
    found = opened.attrs.get("format")
    if found not in READABLE or "base_rate" not in opened.attrs:
        opened.close()
        what = "it is not a run record" if found is None else f"its format is {found}"
        raise InputError(f"{target}: {what}; this version reads formats 1 to {FORMAT_VERSION}.")
    numerator, denominator = (int(part) for part in opened.attrs["base_rate"])
    texts = cache(partial(read_texts, folder))
    stores = {
        name: FileStore(node, lambda name=name: texts().get(name, ()))
        for name, node in opened.items()
    }
    rate = Fraction(numerator, denominator)
    start_tick = int(opened.attrs.get("start_tick", 0))
    return Run(folder, stores, rate, read_manifest(folder), opened.close, start_tick=start_tick)


def read_manifest(folder: Path) -> dict[str, Any]:
    """The folder's manifest; empty where it is missing or was cut off."""
    try:
        return json.loads((folder / MANIFEST_FILE).read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return {}
