"""Files are found beside the file that names them; a resolved scenario runs from anywhere."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from cosim.analysis import load_tuned
from cosim.record.digest import digest
from cosim.record.reader import open_run
from cosim.run import run_scenario

SCENARIO = """\
cohaptic: 1
duration: 0.1
rates: {control: 1024}
components:
  source: {fmu: signal, station: a, rate: control, include: part.yaml}
  body: {fmu: object, station: b, rate: control}
channels:
  lan: {between: [a, b], rate: control, trace: data/trace.txt}
connections:
  - source.value -> body.force[1] via lan
"""
TABLE = "0 0\n0.05 1\n0.1 0\n"


@pytest.fixture
def home(tmp_path: Path) -> Path:
    home = tmp_path / "home"
    (home / "data").mkdir(parents=True)
    (home / "s.yaml").write_text(SCENARIO)
    (home / "part.yaml").write_text("parameters: {mode: table, table_file: data/table.txt}\n")
    (home / "data" / "table.txt").write_text(TABLE)
    (home / "data" / "trace.txt").write_text("0.001\nlost\n")
    return home


def test_the_same_digest_from_another_folder(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    first = run_scenario(load_tuned("../home/s.yaml"), elsewhere / "first", figure=False).folder
    again = load_tuned(first / "scenario.resolved.yaml")
    second = run_scenario(again, elsewhere / "second", figure=False).folder
    assert digest(open_run(first)) == digest(open_run(second))
    files = json.loads((first / "manifest.json").read_text())["files"]
    assert files == {
        str(home / "data" / name): hashlib.sha256((home / "data" / name).read_bytes()).hexdigest()
        for name in ("table.txt", "trace.txt")
    }


def test_an_override_starts_from_the_working_folder(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.txt").write_text(TABLE)
    scenario = load_tuned("home/s.yaml", (), ["components.source.parameters.table_file=mine.txt"])
    folder = run_scenario(scenario, tmp_path / "run", figure=False).folder
    files = json.loads((folder / "manifest.json").read_text())["files"]
    assert str(tmp_path / "mine.txt") in files
