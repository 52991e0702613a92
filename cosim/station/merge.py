"""Two sides' records on one time base: the session's ticks, which both stations share."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import permutations
from math import lcm
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.base.recording import Column, RecordGroup, TextColumn
from cosim.record.folder import new_folder
from cosim.record.manifest import write_manifest
from cosim.record.reader import RUN_FILE, SCENARIO_FILE, Run, open_run
from cosim.record.signals import RecordedSignal
from cosim.record.texts.recorded import RecordedText
from cosim.record.writer import Recorder
from cosim.station.measured import write_traces

FULL_SCENARIO_FILE = "scenario.full.yaml"
"""Beside a station's record: the scenario of all stations, which the merged run is one of."""
ROWS_AT_A_TIME = 4096


@dataclass(frozen=True, slots=True)
class Merged:
    """Where the merged run lies, and which session ticks it covers (tick 0 is the first)."""

    folder: Path
    first_tick: int
    ticks: int
    signals: int
    measured: Path | None
    """An overlay that has the simulated channel treat every packet as this session did."""


def merge_runs(folders: tuple[Path, ...], out: Path | None = None) -> Merged:
    """Put the records of several stations of one session together.

    A row of the result holds what every station recorded at the same session tick; the result
    begins at the first and ends at the last tick that all have. Signals of one name get their
    station's name in front.

    Raises:
        InputError: a folder holds no station's run, or they do not overlap in time.
    """
    if len(folders) < 2:
        raise InputError("give the run folders of two stations or more")
    runs = [open_run(folder) for folder in folders]
    try:
        return _merge(runs, out)
    finally:
        for run in runs:
            run.close()


def _merge(runs: list[Run], out: Path | None) -> Merged:
    links = [_link_of(run) for run in runs]
    stations = [str(link["station"]) for link in links]
    if len(set(stations)) < len(stations):
        raise InputError(f"two of the runs are of station {stations[0]}; merge different stations")
    if len({(run.base_rate, run.start_tick) for run in runs}) > 1:
        raise InputError(
            "the runs have different base rates or start times; they are not of one session"
        )
    _refuse_strangers(dict(zip(stations, links, strict=True)))
    periods = lcm(*(group.period for run in runs for group in run.groups.values()))
    firsts = [int(link["first_tick"]) for link in links]
    # Every group has a row at a multiple of all periods.
    first = -(-max(firsts) // periods) * periods
    end = min(begin + run.ticks for begin, run in zip(firsts, runs, strict=True))
    if end <= first:
        raise InputError("the runs do not overlap in time; are they of one session?")
    name = "-".join(["merged", *stations])
    folder = new_folder(name, out)
    parts = _parts(runs, stations)
    groups = [
        RecordGroup(
            name=label,
            period=period,
            columns=tuple(column for _, _, column in part.signals),
            texts=tuple(column for _, _, column in part.texts),
        )
        for (label, period), part in parts.items()
    ]
    base_rate = runs[0].base_rate
    with Recorder(folder / RUN_FILE, end - first, runs[0].start_tick) as recorder:
        recorder.begin(groups, base_rate)
        shifts = dict(zip(map(id, runs), (first - begin for begin in firsts), strict=True))
        for number, part in enumerate(parts.values()):
            _copy(recorder, number, part.signals, shifts, end - first)
            _copy_texts(recorder, number, part.texts, shifts, end - first)
    full = runs[0].folder / FULL_SCENARIO_FILE
    if full.exists():
        shutil.copyfile(full, folder / SCENARIO_FILE)
    manifest: dict[str, Any] = {
        **runs[0].manifest,
        "link": None,
        **_told(dict(zip(stations, runs, strict=True)), end - first),
        # Each station kept its own time; its manifest says how.
        "timing": None,
        "deadlines": None,
        "merged": {
            "first_tick": first,
            "runs": {s: str(run.folder) for s, run in zip(stations, runs, strict=True)},
            "links": {s: dict(link) for s, link in zip(stations, links, strict=True)},
            "deadlines": {
                s: run.manifest.get("deadlines") for s, run in zip(stations, runs, strict=True)
            },
        },
    }
    write_manifest(folder, manifest)
    known = dict(zip(stations, runs, strict=True))
    measured = write_traces(folder, folder / SCENARIO_FILE, known) if full.exists() else None
    signals = sum(len(group.columns) + len(group.texts) for group in groups)
    return Merged(folder, first, end - first, signals, measured)


def _refuse_strangers(links: Mapping[str, Mapping[str, Any]]) -> None:
    """Refuse stations that met, but not each other's record.

    Raises:
        InputError: two of them have no session in common.
    """
    for one, other in permutations(links, 2):
        own, others = _sessions(links[one], other), _sessions(links[other], one)
        if own and others and own.isdisjoint(others):
            raise InputError(
                f"the runs of {one} and {other} have no session in common: each of them met "
                "another run; merge those of one session"
            )


def _sessions(link: Mapping[str, Any], peer: str) -> set[str]:
    peers: Mapping[str, Mapping[str, Any]] = link.get("peers") or {}
    return {*(peers.get(peer) or {}).get("sessions", ())}


def _told(runs: Mapping[str, Run], ticks: int) -> dict[str, Any]:
    """How the stations ended, the worst of it, and what each of them warns of."""
    cut_off = {"status": 1, "message": "The run was cut off."}
    endings = {station: run.manifest.get("exit") or cut_off for station, run in runs.items()}
    said = [f"{s}: {end['message']}" for s, end in endings.items() if end["message"]]
    warnings: dict[str, Mapping[str, Any]] = {
        s: run.manifest.get("warnings") or {} for s, run in runs.items()
    }
    notes: dict[str, list[str]] = {s: run.manifest.get("notes") or [] for s, run in runs.items()}
    first, *others = notes.values()
    shared = set(first).intersection(*others)
    return {
        "exit": {
            "status": max(int(end["status"]) for end in endings.values()),
            "message": "\n".join(said),
            "ticks": ticks,
        },
        "warnings": {
            f"{station}: {name}": value
            for station, each in warnings.items()
            for name, value in each.items()
        },
        "notes": [
            *(note for note in first if note in shared),
            *(f"{s}: {note}" for s, each in notes.items() for note in each if note not in shared),
        ],
    }


_Signal = tuple[Run, RecordedSignal, Column]
_Text = tuple[Run, RecordedText, TextColumn]


@dataclass(frozen=True, slots=True)
class _Part:
    """What is recorded at one rate: of which run, and under which name."""

    signals: list[_Signal] = field(default_factory=list[_Signal])
    texts: list[_Text] = field(default_factory=list[_Text])


def _parts(runs: list[Run], stations: list[str]) -> dict[tuple[str, int], _Part]:
    """The signals and texts of each rate, with the names they get."""
    groups = [group for run in runs for group in run.groups.values()]
    names = [name for group in groups for name in (*group.signals, *group.texts)]
    found: dict[tuple[str, int], _Part] = {}
    for run, station in zip(runs, stations, strict=True):
        for label, group in run.groups.items():
            part = found.setdefault((label, group.period), _Part())
            for name, signal in group.signals.items():
                own = name if names.count(name) == 1 else f"{station}.{name}"
                # All that is known of a signal goes along: what it means, whose it is.
                renamed = replace(signal.column, name=own)
                part.signals.append((run, signal, renamed))
            for name, text in group.texts.items():
                own = name if names.count(name) == 1 else f"{station}.{name}"
                part.texts.append((run, text, replace(text.column, name=own)))
    return found


def _copy(
    recorder: Recorder, number: int, columns: list[_Signal], shifts: Mapping[int, int], ticks: int
) -> None:
    period = recorder.groups[number].period
    rows = -(-ticks // period)
    for start in range(0, rows, ROWS_AT_A_TIME):
        count = min(ROWS_AT_A_TIME, rows - start)
        cells = recorder.buffer(number, count)
        for place, (run, signal, _) in enumerate(columns):
            first = shifts[id(run)] // period + start
            cells[:, place] = np.ascontiguousarray(signal[first : first + count]).view(np.int64)
        recorder.commit(number, start * period, count)


def _copy_texts(
    recorder: Recorder, number: int, texts: list[_Text], shifts: Mapping[int, int], ticks: int
) -> None:
    """Their changes, the first of which is what each was at the first tick."""
    for place, (run, text, _) in enumerate(texts):
        shift = shifts[id(run)]
        begin = [(0, content) for tick, content in text.changes if tick <= shift][-1:]
        after = [(tick - shift, content) for tick, content in text.changes if tick > shift]
        for tick, content in (*begin, *after):
            if tick < ticks:
                recorder.put_text(number, place, tick, content)


def _link_of(run: Run) -> Mapping[str, Any]:
    link = run.manifest.get("link")
    if not link:
        raise InputError(
            f"{run.folder}: not the run of one station; 'cohaptic merge' takes those of "
            "'cohaptic station'"
        )
    return link
