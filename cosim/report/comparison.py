"""Two runs side by side: what ran, what was measured, and where the first value differs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from cosim.base.document.yaml_reader import parse_yaml
from cosim.record.reader import SCENARIO_FILE, Run
from cosim.record.signals import SignalGroup
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
    largest: float
    """The largest difference; NaN where one of them is not a number."""
    is_text: bool = False
    """Whether no number says by how much."""


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Everything in which two runs differ."""

    scenario: list[Change]
    versions: list[Change]
    measures: list[Change]
    only_in: tuple[list[str], list[str]]
    """Signals that only one of them has, by ``group.signal``."""
    lengths: tuple[int, int]
    """Base ticks of each."""
    signals: list[SignalDifference]
    """The first to differ first."""

    @property
    def are_equal(self) -> bool:
        """Whether both have the same signals with the same values, bit for bit."""
        one, other = self.only_in
        return not (one or other or self.signals) and self.lengths[0] == self.lengths[1]


def _text_differences(one: SignalGroup, other: SignalGroup) -> Iterator[SignalDifference]:
    """Texts differ from row to row; by how much, no number says."""
    end = min(one.rows, other.rows) * one.period
    for name, mine in one.texts.items():
        theirs = other.texts.get(name)
        if theirs is None:
            continue
        ticks = sorted({tick for text in (mine, theirs) for tick, _ in text.changes if tick < end})
        apart = [
            (tick, until)
            for tick, until in pairwise([*ticks, end])
            if mine.at(tick) != theirs.at(tick)
        ]
        if apart:
            rows = sum(-(-(until - tick) // one.period) for tick, until in apart)
            yield SignalDifference(name, "", apart[0][0], rows, float("nan"), is_text=True)


def compare_runs(one: Run, other: Run) -> RunComparison:
    """Compare two open runs; signals as far as both go."""
    names = [_names(run) for run in (one, other)]
    pairs = list(_common(one, other))
    signals = [
        found for pair in pairs for found in (*_differences(*pair), *_text_differences(*pair))
    ]
    return RunComparison(
        scenario=changes(_scenario(one), _scenario(other)),
        versions=changes(_versions(one), _versions(other)),
        measures=changes(_measures(one), _measures(other)),
        only_in=(sorted(names[0] - names[1]), sorted(names[1] - names[0])),
        lengths=(one.ticks, other.ticks),
        signals=sorted(signals, key=lambda each: (each.tick, each.name)),
    )


def _names(run: Run) -> set[str]:
    return {
        f"{group.name}.{name}"
        for group in run.groups.values()
        for name in (*group.signals, *group.texts)
    }


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
    return [] if one == other else [(path, one, other)]


def _common(one: Run, other: Run) -> Iterator[tuple[SignalGroup, SignalGroup]]:
    for name, group in one.groups.items():
        there = other.groups.get(name)
        if there is not None and there.rate == group.rate:
            yield group, there


def _differences(one: SignalGroup, other: SignalGroup) -> Iterator[SignalDifference]:
    for name, mine in one.signals.items():
        theirs = other.signals.get(name)
        if theirs is None:
            continue
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
            yield SignalDifference(name, mine.unit, tick, rows, largest)


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
        "files": {Path(name).name: digest for name, digest in files.items()},
    }


def _measures(run: Run) -> dict[str, Any]:
    try:
        content = json.loads((run.folder / SUMMARY_FILE).read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return {}
    return {
        "status": content.get("status"),
        **content.get("measures", {}),
        **{
            f"{each['target']} {each['predicate']}": each["measured"]
            for each in content.get("expectations", [])
        },
    }
