"""What a station recorded means the same in the merged run, so its measures and figures work."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column, RecordGroup, TextColumn
from cosim.cli.support.run.merged_page import joined, write_merged_page
from cosim.record import open_run
from cosim.record.manifest import write_manifest
from cosim.record.reader import RUN_FILE
from cosim.record.writer import Recorder
from cosim.report.page.stations import station_table
from cosim.report.summary import summarise
from cosim.station.merge import merge_runs

TICKS = 100
POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)


def recorded(folder: Path, station: str, at: float, **more: Any) -> Path:
    """A station's run: its copy of the box at rest ``at`` (m); ``more`` is in its manifest."""
    folder.mkdir()
    columns = tuple(
        Column(
            name=f"vr_{station}.box.{meaning.name}",
            unit="rad" if meaning is Meaning.BOX_ANGLE else "m",
            is_float=True,
            items=(),
            meaning=meaning,
            belongs_to=Slot(None, None),
        )
        for meaning in POSE
    )
    with Recorder(folder / RUN_FILE, TICKS) as recorder:
        recorder.begin([RecordGroup(name="fast", period=1, columns=columns)], Fraction(1024))
        cells = recorder.buffer(0, TICKS)
        cells[:] = np.full((TICKS, 3), at).view(np.int64)
        recorder.commit(0, 0, TICKS)
    link = {"station": station, "first_tick": 0, **more.pop("link", {})}
    write_manifest(folder, {"link": link, "scenario": {}, "deadlines": {"misses": 3}, **more})
    return folder


def test_meanings_go_along_and_the_drift_between_copies_is_found(tmp_path) -> None:
    folders = tuple(recorded(tmp_path / name, name, at) for name, at in (("a", 0.0), ("b", 0.003)))
    merged = merge_runs(folders, tmp_path / "merged")
    with open_run(merged.folder) as run:
        assert {signal.meaning for signal in run.signals.values()} == set(POSE)
        assert summarise(run).content["measures"]["drift"] == pytest.approx(0.003 * 2**0.5)
        assert run.manifest["deadlines"] is None


def met(peer: str, *sessions: str) -> dict[str, Any]:
    return {"link": {"peers": {peer: {"sessions": [*sessions]}}}}


def test_runs_that_met_others_are_not_put_together(tmp_path) -> None:
    a = recorded(tmp_path / "a", "a", 0.0, **met("b", "01", "02"))
    b = recorded(tmp_path / "b", "b", 0.0, **met("a", "02", "03"))
    c = recorded(tmp_path / "c", "b", 0.0, **met("a", "03"))
    alone = recorded(tmp_path / "alone", "b", 0.0, **met("a"))
    assert merge_runs((a, b), tmp_path / "merged").ticks == TICKS
    assert merge_runs((a, alone), tmp_path / "early").ticks == TICKS
    with pytest.raises(InputError, match="a and b have no session in common"):
        merge_runs((a, c), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_merged_run_ended_as_the_worst_of_its_stations_did(tmp_path) -> None:
    good = {"exit": {"status": 0, "message": "", "ticks": TICKS}}
    bad = {"exit": {"status": 1, "message": "vr_b: its FMU died.", "ticks": 90}}
    warned = {"warnings": {"lan": 3}, "notes": ["both", "b alone"]}
    folders = (
        recorded(tmp_path / "a", "a", 0.0, **good, notes=["both"]),
        recorded(tmp_path / "b", "b", 0.0, **bad, **warned),
    )
    merged = merge_runs(folders, tmp_path / "merged")
    with open_run(merged.folder) as run:
        found = summarise(run)
        assert (found.status, found.content["message"]) == (1, "b: vr_b: its FMU died.")
        assert found.content["warnings"] == {"b: lan": 3}
        assert run.manifest["notes"] == ["both", "b: b alone"]
        page = write_merged_page(run, folders).read_text()
    assert "b: vr_b: its FMU died." in page
    assert 'class="outcome bad"' in page


def talking(folder: Path, station: str, first: int, said: list[tuple[int, bytes]]) -> Path:
    """A station's run that begins at a tick of the session, with a number and a text."""
    folder.mkdir()
    column = Column(name=f"{station}.x", unit="1", is_float=True)
    text = TextColumn(name="task", is_binary=False)
    groups = [
        RecordGroup(name="fast", period=1, columns=(column,), texts=(text,)),
        RecordGroup(name="words", period=2, columns=(), texts=(replace(text, name=station),)),
    ]
    with Recorder(folder / RUN_FILE, TICKS) as recorder:
        recorder.begin(groups, Fraction(1024))
        for number, rows in ((0, TICKS), (1, TICKS // 2)):
            recorder.buffer(number, rows)[:] = 0
            recorder.commit(number, 0, rows)
        for tick, content in said:
            recorder.put_text(0, 0, tick, content)
        recorder.put_text(1, 0, 0, station.encode())
    write_manifest(folder, {"link": {"station": station, "first_tick": first}, "scenario": {}})
    return folder


def test_texts_are_merged_on_the_session_ticks(tmp_path: Path) -> None:
    """What a station said before the first tick that all have is what holds at it."""
    folders = (
        talking(tmp_path / "a", "a", 0, [(0, b"rest"), (8, b"reach"), (12, b"hold"), (60, b"go")]),
        talking(tmp_path / "b", "b", 20, [(0, b"wait"), (90, b"late")]),
    )
    merged = merge_runs(folders, tmp_path / "merged")
    assert (merged.first_tick, merged.ticks, merged.signals) == (20, 80, 6)
    with open_run(merged.folder) as run:
        texts = {
            name: list(zip(t.ticks.tolist(), t.values, strict=True))
            for name, t in run.texts.items()
        }
    assert texts == {
        "a.task": [(0, "hold"), (40, "go")],
        "b.task": [(0, "wait")],
        "a": [(0, "a")],
        "b": [(0, "b")],
    }


def test_the_page_has_the_stations_beside_each_other(tmp_path) -> None:
    folders = tuple(recorded(tmp_path / name, name, 0.0) for name in "ab")
    merged = merge_runs(folders, tmp_path / "merged")
    with open_run(merged.folder) as run:
        page = write_merged_page(run, folders).read_text()
    assert "The stations beside each other" in page
    row = re.search(r"deadlines: misses</th><td>3</td><td>3</td>", page)
    assert row, "each station kept its own time"
    assert "vr_a.box" in page
    assert "vr_b.box" in page
    assert "hold no scenario that both agreed on" in page


def test_a_scenario_that_cannot_be_read_is_said_on_the_page(tmp_path) -> None:
    folders = tuple(recorded(tmp_path / name, name, 0.0) for name in "ab")
    merged = merge_runs(folders, tmp_path / "merged")
    (merged.folder / "scenario.resolved.yaml").write_text(
        "cohaptic: 1\ncomponents: {hand: {python: laboratory:Hand}}\n", encoding="utf-8"
    )
    with open_run(merged.folder) as run:
        page = write_merged_page(run, folders).read_text()
    assert "the theory says nothing here. scenario.resolved.yaml cannot be read here:" in page


def test_what_was_sent_and_what_came_are_counted_apart() -> None:
    stream = {"accepted": 8, "withheld": 5, "delay": 1, "late_after": 4, "last_reason": "none"}
    link = {"peers": {"b": {"sent": 9, "withheld": 2, "streams": {"lan": stream, "wan": stream}}}}
    table = station_table({"merged": {"links": {"a": link}}})
    assert table is not None
    assert dict(table["rows"]) == {
        "packets: sent": "9",
        "packets: withheld": "2",
        "received: accepted": "16",
        "received: withheld": "10",
    }


def test_the_clocks_nanoseconds_are_told_as_times() -> None:
    peer = {"round_trip": 61922, "clock_offset": -4496, "streams": {}}
    table = station_table({"merged": {"links": {"a": {"peers": {"b": peer}}}}})
    assert table is not None
    assert {("round trip", "61.9 µs"), ("clock offset", "-4.5 µs")} <= {*table["rows"]}


def test_scenes_are_joined_and_equal_things_are_one() -> None:
    wall, a, b = [0, 0, 1, 0], {"name": "vr_a"}, {"name": "vr_b"}
    one, other = {"boxes": [a], "walls": [wall]}, {"boxes": [b], "walls": [wall]}
    assert joined([one, None, other]) == {"boxes": [a, b], "walls": [wall]}
