"""Two runs side by side: what ran, what was measured, and where the first value differs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from cosim.base.document.yaml_reader import parse_yaml
from cosim.record.reader import SCENARIO_FILE, Run
from cosim.record.signals import RecordedSignal, SignalGroup
from cosim.record.texts.recorded import RecordedText
from cosim.report.summary import SUMMARY_FILE

Change = tuple[str, Any, Any]
"""A path or a name, and what either run has there; ``None`` where it has nothing."""

_UNTOLD = frozenset({"name", "title", "description"})


@dataclass(frozen=True, slots=True)
class SignalDifference:
    """A signal that is not the same in both: since when, in how many rows, and by how much."""

    name: str
    unit: str
    tick: int
    rows: int
    largest: float | None
    """The largest difference; ``None`` where one of them is not a number."""
    is_text: bool = False
    """Whether no number says by how much."""


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Everything in which two runs differ."""

    scenario: list[Change]
    versions: list[Change]
    measures: list[Change]
    recorded: list[Change]
    """Rates, start, rows, units and types: what values are compared by."""
    only_in: tuple[list[str], list[str]]
    """Signals that only one of them has, by ``group.signal``."""
    lengths: tuple[int, int]
    """Base ticks of each."""
    signals: list[SignalDifference]
    """The first to differ first."""
    compared: int
    """Signals and texts compared by value: of one name, unit and type, at the same times."""

    @property
    def are_equal(self) -> bool:
        """Whether both have the same signals with the same values: one digest, that is."""
        one, other = self.only_in
        apart = one or other or self.recorded or self.signals
        return not apart and self.lengths[0] == self.lengths[1]


def compare_runs(one: Run, other: Run) -> RunComparison:
    """Compare two open runs; signals as far as both go, row by row.

    Only what is of one unit and type, and whose rows are of the same times, is compared by value.
    """
    names = [_names(run) for run in (one, other)]
    pairs = [
        (group, other.groups[name]) for name, group in one.groups.items() if name in other.groups
    ]
    recorded = changes(_times(one), _times(other))
    alike = [pair for pair in pairs if not recorded and pair[0].period == pair[1].period]
    signals = [
        found
        for mine, theirs in alike
        for found in (*_differences(mine, theirs), *_text_differences(mine, theirs))
    ]
    for mine, theirs in pairs:
        recorded += _kept_otherwise(mine, theirs, rows_count=one.ticks == other.ticks)
    return RunComparison(
        scenario=changes(_scenario(one), _scenario(other)),
        versions=changes(_versions(one), _versions(other)),
        measures=changes(_measures(one), _measures(other)),
        recorded=recorded,
        only_in=(sorted(names[0] - names[1]), sorted(names[1] - names[0])),
        lengths=(one.ticks, other.ticks),
        signals=sorted(signals, key=lambda each: (each.tick, each.name)),
        compared=sum(len(_signals(*pair)) + len(_texts(*pair)) for pair in alike),
    )


def changes(one: Any, other: Any, path: str = "") -> list[Change]:
    """What differs between two trees of plain values, by path."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        mine, theirs = cast("Mapping[str, Any]", one), cast("Mapping[str, Any]", other)
        keys = dict.fromkeys([*mine, *theirs])
        return [
            found
            for key in keys
            for found in changes(mine.get(key), theirs.get(key), f"{path}.{key}" if path else key)
        ]
    return [] if one == other or (_is_nan(one) and _is_nan(other)) else [(path, one, other)]


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _names(run: Run) -> set[str]:
    return {
        f"{group.name}.{name}"
        for group in run.groups.values()
        for name in (*group.signals, *group.texts)
    }


def _times(run: Run) -> dict[str, str]:
    return {"base rate": f"{run.base_rate} Hz", "start": f"tick {run.start_tick}"}


def _kept_otherwise(one: SignalGroup, other: SignalGroup, *, rows_count: bool) -> Iterator[Change]:
    """In what rows, units and types of a group differ; its length where nothing else tells it."""
    if one.period != other.period:
        yield one.name, f"{one.rate} Hz", f"{other.rate} Hz"
    elif rows_count and one.rows != other.rows:
        yield one.name, f"{one.rows} rows", f"{other.rows} rows"
    else:
        for first, last in one.pieces(0, min(one.rows, other.rows)):
            mine, theirs = one.ticks_of(first, last), other.ticks_of(first, last)
            if (apart := np.flatnonzero(mine != theirs)).size:
                row = int(apart[0])
                yield f"{one.name}, row {first + row}", f"tick {mine[row]}", f"tick {theirs[row]}"
                break
    for name, signal in one.signals.items():
        if (there := other.signals.get(name)) is not None:
            yield from changes(_kind(signal), _kind(there), name)
            yield from changes(signal.unit or None, there.unit or None, name)
    for name, text in one.texts.items():
        if (words := other.texts.get(name)) is not None:
            yield from changes(_text_kind(text), _text_kind(words), name)


def _kind(signal: RecordedSignal) -> str:
    return "float64" if signal.is_float else "int64"


def _text_kind(text: RecordedText) -> str:
    return "Binary" if text.column.is_binary else "String"


def _signals(
    one: SignalGroup, other: SignalGroup
) -> dict[str, tuple[RecordedSignal, RecordedSignal]]:
    """Those of one name, unit and type: of others the numbers say nothing beside one another."""
    return {
        name: (mine, theirs)
        for name, mine in one.signals.items()
        if (theirs := other.signals.get(name)) is not None
        and (_kind(mine), mine.unit or None) == (_kind(theirs), theirs.unit or None)
    }


def _texts(one: SignalGroup, other: SignalGroup) -> dict[str, tuple[RecordedText, RecordedText]]:
    return {
        name: (mine, theirs)
        for name, mine in one.texts.items()
        if (theirs := other.texts.get(name)) is not None and _text_kind(mine) == _text_kind(theirs)
    }


def _differences(one: SignalGroup, other: SignalGroup) -> Iterator[SignalDifference]:
    for name, (mine, theirs) in _signals(one, other).items():
        tick, rows, largest = -1, 0, 0.0
        for first, last in one.pieces(0, min(one.rows, other.rows)):
            differs = mine.cells(first, last) != theirs.cells(first, last)
            if not differs.any():
                continue
            rows += int(np.count_nonzero(differs))
            with np.errstate(invalid="ignore"):
                by = np.abs(mine[first:last][differs].astype(float) - theirs[first:last][differs])
            largest = float(np.maximum(largest, by.max()))
            if tick < 0:
                row = first + int(differs.argmax())
                tick = int(one.ticks_of(row, row + 1)[0])
        if rows:
            by_how_much = largest if np.isfinite(largest) else None
            yield SignalDifference(name, mine.unit, tick, rows, by_how_much)


def _text_differences(one: SignalGroup, other: SignalGroup) -> Iterator[SignalDifference]:
    """Texts differ from row to row; by how much, no number says."""
    end = min(one.rows, other.rows) * one.period
    for name, (mine, theirs) in _texts(one, other).items():
        ticks = sorted({tick for text in (mine, theirs) for tick, _ in text.changes if tick < end})
        apart = [
            (tick, until)
            for tick, until in pairwise([*ticks, end])
            if mine.at(tick) != theirs.at(tick)
        ]
        if apart:
            rows = sum(-(-(until - tick) // one.period) for tick, until in apart)
            yield SignalDifference(name, "", apart[0][0], rows, None, is_text=True)


def _scenario(run: Run) -> Any:
    text = run.scenario_yaml
    plain: dict[str, Any] = parse_yaml(text, SCENARIO_FILE).plain() if text else {}
    return {key: value for key, value in plain.items() if key not in _UNTOLD}


def _versions(run: Run) -> dict[str, Any]:
    manifest = run.manifest
    files: dict[str, str] = manifest.get("files", {})
    git: dict[str, Any] = manifest.get("git") or {}
    components: dict[str, Any] = manifest.get("components", {})
    fmus = {name: part.get("sha256") for name, part in components.items()}
    return {
        **(manifest.get("versions") or {}),
        "commit": git.get("commit"),
        "fmus": {name: digest for name, digest in fmus.items() if digest},
        "files": {_called(name, files): digest for name, digest in files.items()},
    }


def _called(file: str, files: Mapping[str, str]) -> str:
    """Its name alone, as far as that tells it from the others: folders are moved."""
    name = Path(file).name
    return name if [Path(each).name for each in files].count(name) == 1 else file


def _measures(run: Run) -> dict[str, Any]:
    try:
        content = json.loads((run.folder / SUMMARY_FILE).read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return {}
    return {
        "status": content.get("status"),
        **content.get("measures", {}),
        **{_claim(each): each["measured"] for each in content.get("expectations", [])},
    }


def _claim(verdict: Mapping[str, Any]) -> str:
    label = f" ({verdict['label']})" if verdict.get("label") else ""
    return f"{verdict['target']}{label} {verdict['predicate']}"
