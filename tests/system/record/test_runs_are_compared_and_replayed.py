"""Two runs are told apart by their first differing value; a run is computed again and compared."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import record
from cosim.cli.recorded import compare, replay
from cosim.cli.recorded import listing as runs
from cosim.reading import load
from cosim.run import run_scenario

SETS = ["duration=0.25 s", "channels.lan.loss=0.1"]


def made(folder: Path, *sets: str, scenario: str = "single_axis_distributed") -> Path:
    return run_scenario(load(scenario, sets=[*SETS, *sets]), folder, figure=False).folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    made(folder / "one")
    made(folder / "same")
    made(folder / "heavier", "components.object_1.parameters.mass=0.5")
    made(folder / "longer", "duration=0.3 s")
    return folder


def invoke(module: Any, *arguments: object) -> tuple[int, str]:
    given = [str(argument) for argument in arguments]
    result = CliRunner().invoke(module.command, given, catch_exceptions=False)
    return result.exit_code, result.stdout


def test_equal_runs(folder: Path) -> None:
    status, text = invoke(compare, folder / "one", folder / "same")
    assert status == 0
    assert "no value differs in the first 256 ticks" in text


def test_the_first_difference_is_told(folder: Path, tmp_path: Path) -> None:
    figure = tmp_path / "both.png"
    status, text = invoke(compare, folder / "one", folder / "heavier", "--figure", figure)
    assert status == 1
    assert "components.object_1.parameters.mass: 0.4 → 0.5" in text
    assert figure.stat().st_size > 1000
    content = json.loads(invoke(compare, folder / "one", folder / "heavier", "--json")[1])
    first = content["signals"][0]
    # The step begins at 0.1 s; the mass counts one tick after the first force.
    assert 102 < first["tick"] < 110
    assert [each["tick"] for each in content["signals"]] == sorted(
        each["tick"] for each in content["signals"]
    )


def test_a_longer_run_is_another_one(folder: Path) -> None:
    status, text = invoke(compare, folder / "one", folder / "longer")
    assert status == 1
    assert "duration: 0.25 → 0.3" in text
    assert "no value differs in the first 256 ticks" in text


def test_a_run_is_replayed(folder: Path, tmp_path: Path) -> None:
    status, text = invoke(replay, folder / "one")
    assert status == 0
    assert "all 256 ticks are the same, bit for bit" in text
    kept = tmp_path / "kept"
    assert invoke(replay, folder / "one", "--out", kept)[0] == 0
    assert invoke(compare, folder / "one", kept)[0] == 0


def test_where_a_replay_differs_is_told(tmp_path: Path) -> None:
    changed = made(tmp_path / "changed")
    with h5py.File(changed / "run.h5", "r+") as file:
        values = file["control"]["float64"]
        values[3, 200] = values[3, 200] + 1e-12
    status, text = invoke(replay, changed)
    assert status == 1
    assert "at tick 200" in text


def test_a_run_that_was_cut_short_is_replayed_as_far_as_it_came(
    folder: Path, tmp_path: Path
) -> None:
    cut = made(tmp_path / "cut", "duration=0.1 s")
    resolved = (cut / "scenario.resolved.yaml").read_text()
    (cut / "scenario.resolved.yaml").write_text(resolved.replace("duration: 0.1", "duration: 5"))
    status, text = invoke(replay, cut)
    assert status == 0
    assert "all 103 ticks" in text


def test_a_device_is_played_back(tmp_path: Path) -> None:
    scenario = load("two_users_box", ["devices/mock"], ["duration=0.2 s", "expect=~"])
    played = run_scenario(scenario, tmp_path / "run", figure=False).folder
    status, text = invoke(replay, played)
    assert status == 0
    assert "bit for bit" in text


def test_a_digest_is_expected(folder: Path) -> None:
    _, text = invoke(record, "digest", folder / "one")
    wanted = text.split()[0]
    assert invoke(record, "digest", folder / "same", "--expect", wanted)[0] == 0
    assert invoke(record, "digest", folder / "same", "--expect", folder / "one")[0] == 0
    status, text = invoke(record, "digest", folder / "one", folder / "heavier", "--expect", wanted)
    assert status == 1
    assert f"{folder / 'heavier'} is not" in text


def test_runs_are_found_by_value(folder: Path) -> None:
    def names(*where: str) -> set[str]:
        options = [part for text in where for part in ("--where", text)]
        status, text = invoke(runs, folder, *options, "--json")
        assert status == 0
        return {Path(each["folder"]).name for each in json.loads(text)["runs"]}

    assert names() == {"one", "same", "heavier", "longer"}
    assert names("object_1.mass=0.5") == {"heavier"}
    assert names("components.object_1.parameters.mass<0.45", "duration>0.26") == {"longer"}
    assert names("lan.loss.forward>0", "object_1.mass!=0.4") == {"heavier"}
    assert names("object_1.mass<450 g", "duration>=300 ms") == {"longer"}
    assert names("scenario!=single_axis_distributed") == set()
    assert names("status=good") == names("started>2020", "simulated_time<1 min") == names()
    assert names("status=failed") == names("drift<2 mm") == set()
    assert "no run" in invoke(runs, folder, "--where", "seed=99")[1]
    assert "heavier" in invoke(runs, folder)[1]


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("nothing=1", "has 'nothing'"),
        ("drfit<2 mm", "Did you mean drift?"),
        ("drift<2 s", "does not convert to m"),
        ("object_1.mass=heavy", "is a number"),
        ("object_1.mass<2 kgs", "is a number"),
        ("scenario>single_user", "is compared by = and !="),
        ("drift", "write NAME=VALUE"),
        ("=3", "write NAME=VALUE"),
    ],
)
def test_what_cannot_be_compared_is_refused(where: str, words: str, folder: Path) -> None:
    with pytest.raises(InputError, match=words):
        invoke(runs, folder, "--where", "seed=99", "--where", where)
