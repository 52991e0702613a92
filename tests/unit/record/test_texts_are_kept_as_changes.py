"""A recorded text is kept as its changes, and everything that reads a run reads it."""

from __future__ import annotations

import csv
import json
from base64 import b64decode
from pathlib import Path
from typing import Any

import h5py
import pytest

from cosim.base.errors import InputError
from cosim.continuation.continued import Continuation
from cosim.continuation.origin import Origin
from cosim.master.run.simulation import assemble
from cosim.record.digest import digest
from cosim.record.export.formats import EXPORTERS, export
from cosim.record.playback import KINDS
from cosim.record.reader import open_run
from cosim.record.texts.journal import JOURNAL_FILE
from cosim.record.texts.recorded import TEXTS_FILE
from cosim.record.writer import Recorder
from cosim.report.comparison import compare_runs
from cosim.run import run_scenario
from tests.support.master.master_support import scenario_of

PARTS = "tests.support.master.text_parts"
WORDS = [f"n°{n}" for n in range(8)]


def written(**more: Any) -> dict[str, Any]:
    """A counter that counts every eighth tick, recorded together with who repeats it."""
    return {
        "duration": 1,
        "components": {
            "one": {"python": f"{PARTS}:Counter", "rate": 64, "parameters": {"every": 8}},
            "two": {"python": f"{PARTS}:Repeater", "rate": 64},
        },
        "connections": [
            {"from": "one.word", "to": "two.word"},
            {"from": "one.data", "to": "two.data"},
        ],
        "record": ["*"],
        **more,
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder of a run with texts."""
    return record(tmp_path, "run")


def record(tmp_path: Path, name: str, **more: Any) -> Path:
    scenario = scenario_of(tmp_path, written(**more))
    return run_scenario(scenario, tmp_path / name, figure=False).folder


def test_open_run_has_changes_with_their_ticks(folder: Path) -> None:
    with open_run(folder) as run:
        word, data = run.texts["one.word"], run.texts["one.data"]
        assert word.ticks.tolist() == list(range(0, 64, 8))
        assert word.values == WORDS
        assert data.values == [b"\0" + str(n).encode() for n in range(8)]
        assert [word.at(tick) for tick in (0, 7, 8, 63)] == ["n°0", "n°0", "n°1", "n°7"]
        assert "one.word" not in run.signals
        assert set(run.groups["64Hz"].texts) == set(run.texts)
        with pytest.raises(InputError, match=r"one.word is a text.*texts\[one.word\]"):
            run["one.word"]


def test_any_hdf5_reader_opens_them(folder: Path) -> None:
    assert not (folder / JOURNAL_FILE).exists()
    with h5py.File(folder / TEXTS_FILE) as file:
        found = {node.attrs["name"]: node for node in file["64Hz"].values()}
        assert found["one.word"]["value"].asstr()[:].tolist() == WORDS
        assert bytes(found["one.data"]["value"][3]) == b"\x003"
        assert found["one.data"].attrs["type"] == "Binary"


@pytest.mark.parametrize("cut", [0, 1, 30])
def test_a_run_that_was_killed_has_what_it_appended(tmp_path: Path, cut: int) -> None:
    with assemble(scenario_of(tmp_path, written())) as simulation:
        recorder = Recorder(tmp_path / "run.h5", 64)
        simulation.run(recorder)
        assert recorder._journal is not None
        recorder._journal.close()  # as if the process had ended before the recorder's close
        recorder._journal = None
        recorder.close()
    journal = tmp_path / JOURNAL_FILE
    journal.write_bytes(journal.read_bytes()[: -cut or None])
    with open_run(tmp_path) as run:
        kept = run.texts["one.word"].values
        assert kept == WORDS[: len(kept)]
        assert len(kept) >= 7 + (cut == 0)


def test_the_digest_covers_every_change(tmp_path: Path, folder: Path) -> None:
    again = record(tmp_path, "again")
    other = record(tmp_path, "other", record=["one.number", "one.word"])
    fewer = record(tmp_path, "fewer", record=["one.number"])
    with open_run(folder) as a, open_run(again) as b, open_run(other) as c, open_run(fewer) as d:
        assert digest(a) == digest(b)
        assert len({digest(run) for run in (a, c, d)}) == 3
        assert compare_runs(a, b).are_equal
        assert set(compare_runs(c, d).only_in[0]) == {"64Hz.one.word"}


def test_a_comparison_says_since_when_they_differ(tmp_path: Path, folder: Path) -> None:
    parts = written()["components"]
    parts["one"]["parameters"]["every"] = 16
    other = record(tmp_path, "other", components=parts)
    with open_run(folder) as a, open_run(other) as b:
        found = {each.name: each for each in compare_runs(a, b).signals}
    assert (found["one.word"].tick, found["one.word"].rows) == (8, 56)


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("kind", EXPORTERS)
def test_every_format_takes_them(folder: Path, tmp_path: Path, kind: str) -> None:
    if needed := {"mf4": "asammdf", "mcap": "mcap", "parquet": "pyarrow"}.get(kind):
        pytest.importorskip(needed)
    with open_run(folder) as run:
        files = export(run, kind, tmp_path / "out")
    by_name = {file.name: file for file in files}
    if kind == "csv":
        with by_name["64Hz_texts.csv"].open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        found = [(row["signal"], row["value"]) for row in rows]
    elif kind == "parquet":
        table = pytest.importorskip("pyarrow.parquet").read_table(by_name["64Hz_texts.parquet"])
        found = list(zip(table["signal"].to_pylist(), table["value"].to_pylist(), strict=True))
    elif kind == "mat":
        content = pytest.importorskip("scipy.io").loadmat(by_name["run.mat"], simplify_cells=True)
        texts = content["x_64Hz_texts"]
        found = list(zip(texts["signal"], texts["value"], strict=True))
    elif kind == "mf4":
        with pytest.importorskip("asammdf").MDF(by_name["run.mf4"]) as file:
            columns = [file.get(name, group=1).samples.tolist() for name in ("signal", "value")]
        plain = [[each.decode().rstrip("\0") for each in column] for column in columns]
        found = list(zip(*plain, strict=True))
    else:
        reader = pytest.importorskip("mcap.reader")
        with by_name["run.mcap"].open("rb") as stream:
            messages = [
                json.loads(message.data)
                for _, channel, message in reader.make_reader(stream).iter_messages()
                if channel.topic == "/64Hz_texts"
            ]
        found = [(each["signal"], each["value"]) for each in messages]
    assert [value for name, value in found if name == "one.word"] == WORDS
    data = [b64decode(value) for name, value in found if name == "one.data"]
    assert data == [b"\0" + str(n).encode() for n in range(8)]


def exported(folder: Path, out: Path, span: tuple[int, int | None]) -> list[tuple[int, str]]:
    with open_run(folder) as run:
        (file,) = export(run, "csv", out, patterns=["one.word"], span=span)
    with file.open(encoding="utf-8") as content:
        return [(int(row["tick"]), row["value"]) for row in csv.DictReader(content)]


def test_a_window_begins_with_what_was_held(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert exported(folder, out, (12, 30)) == [(12, "n°1"), (16, "n°2"), (24, "n°3")]
    assert exported(folder, out, (16, 17)) == [(16, "n°2")]
    assert exported(folder, out, (60, None)) == [(60, "n°7")]


def test_a_window_behind_the_run_has_no_text(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no row lies in the time"):
        exported(folder, tmp_path / "out", (64, None))
    assert not (tmp_path / "out").exists()


def test_no_group_takes_the_place_of_the_base_rate(tmp_path: Path) -> None:
    loadmat = pytest.importorskip("scipy.io").loadmat
    folder = record(tmp_path, "run", rates={"base_rate": 64})
    with open_run(folder) as run:
        assert "base_rate" in run.groups
        (file,) = export(run, "mat", tmp_path / "out")
    content = loadmat(file, simplify_cells=True)
    assert content["base_rate"].tolist() == [64, 1]
    assert content["base_rate_2"]["tick"].tolist() == list(range(64))


def test_a_playback_says_the_same(tmp_path: Path, folder: Path) -> None:
    parts = written()["components"]
    parts["one"] = {"playback": str(folder), "rate": 64}
    again = record(tmp_path, "again", components=parts)
    with open_run(folder) as a, open_run(again) as b:
        assert digest(a) == digest(b)


@pytest.mark.parametrize("kept", [True, False])
def test_a_run_goes_on_with_its_texts(tmp_path: Path, folder: Path, kept: bool) -> None:
    """From a snapshot as well as again from tick 0; what differs is found."""
    said: list[str] = []
    scenario = scenario_of(tmp_path, written())
    if kept:
        first = run_scenario(
            scenario,
            tmp_path / "first",
            figure=False,
            execute=Continuation(said.append, None, ("0.3125 s",)),
        ).folder
    else:
        first = folder
    on = run_scenario(
        scenario,
        tmp_path / "on",
        figure=False,
        execute=Continuation(said.append, Origin(first, "0.3125 s")),
    )
    assert on.error is None
    with open_run(folder) as a, open_run(on.folder) as b:
        assert digest(a) == digest(b)


def test_a_snapshot_of_a_playback_knows_its_texts(tmp_path: Path) -> None:
    """A record whose texts were written again is another one."""
    folder = record(tmp_path, "run", record=["one.word"])
    parts = {"one": {"playback": str(folder), "rate": 64}}
    scenario = scenario_of(tmp_path, {"duration": 1, "components": parts})
    with assemble(scenario, kinds=KINDS) as simulation:
        simulation.start()
        simulation.advance(9)
        snapshot = simulation.snapshot()
    other = written()["components"]
    other["one"]["parameters"]["every"] = 16
    again = record(tmp_path, "other", components=other, record=["one.word"])
    (folder / TEXTS_FILE).write_bytes((again / TEXTS_FILE).read_bytes())
    with (
        assemble(scenario, kinds=KINDS) as simulation,
        pytest.raises(InputError, match=r"one reads had|one had other"),
    ):
        simulation.restore(snapshot)


def test_texts_alone_are_a_record(tmp_path: Path) -> None:
    folder = record(tmp_path, "run", record=["one.word"])
    with open_run(folder) as run:
        assert run.texts["one.word"].values == WORDS
        assert run.ticks == 64
