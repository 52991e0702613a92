"""Several scenarios in one call: each has its folder and verdict, and CI services read them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import RunError
from cosim.cli.support.run.junit import RunEnd, junit
from tests.support.command import cohaptic
from tests.support.terminal import at_a_terminal

SHORT = ("--duration", "0.05", "--no-figure")
TWO = ("single_user", "single_axis_distributed")
DATED = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+00:00 .")


def test_each_has_a_folder_a_summary_and_a_case(tmp_path: Path) -> None:
    done = cohaptic(
        "run", *TWO, *SHORT, "--out", "all", "--json", "--junit", "j.xml", folder=tmp_path
    )
    assert (done.returncode, done.stderr) == (0, "")
    runs = json.loads(done.stdout)["runs"]
    assert [run["scenario"] for run in runs] == list(TWO)
    assert [run["run"] for run in runs] == [f"all/{name}" for name in TWO]
    assert all((tmp_path / run["run"] / "run.h5").is_file() for run in runs)
    root = ET.parse(tmp_path / "j.xml").getroot()
    assert [suite.get("name") for suite in root] == list(TWO)
    assert root.get("failures") == root.get("errors") == "0"


def test_the_worst_ending_is_the_calls_and_the_others_run_on(tmp_path: Path) -> None:
    away = "away.yaml"
    (tmp_path / away).write_text(
        "cohaptic: 1\ninclude: single_user\nexpect: {hand_1.position: {max_below: -1}}\n"
    )
    done = cohaptic(
        "run", away, "single_user", *SHORT, "--junit", "j.xml", "--log-file", "l", folder=tmp_path
    )
    assert done.returncode == 1
    assert done.stdout.count("simulated in") == 2
    first, second = ET.parse(tmp_path / "j.xml").getroot()
    assert (first.get("tests"), first.get("failures"), second.get("failures")) == ("2", "1", "0")
    (failure,) = first.iter("failure")
    assert "measured 0" in failure.attrib["message"]
    log = (tmp_path / "l").read_text().splitlines()
    assert all(DATED.match(line) for line in log)
    assert any("FAILED" in line for line in log)


def test_nothing_runs_where_one_cannot_be_read(tmp_path: Path) -> None:
    done = cohaptic(
        "run", "single_user", "nowhere", *SHORT, "--junit", "j.xml", "--json", folder=tmp_path
    )
    assert done.returncode == 2
    assert "nowhere" in done.stderr
    (answer,) = json.loads(done.stdout)["runs"]
    assert answer["ok"] is False
    assert not (tmp_path / "runs").exists()
    assert ET.parse(tmp_path / "j.xml").getroot().get("errors") == "1"


@pytest.mark.parametrize("option", [("--from", "runs/a@1 s"), ("--live",), ("--foxglove",)])
def test_what_is_for_one_is_refused_for_several(option: tuple[str, ...], tmp_path: Path) -> None:
    done = cohaptic("run", *TWO, *SHORT, *option, folder=tmp_path)
    assert done.returncode == 2
    assert f"{option[0]}: for one scenario" in done.stderr


def test_verbose_says_what_was_read_and_the_log_has_the_error(tmp_path: Path) -> None:
    done = cohaptic("run", "single_user", *SHORT, "-v", folder=tmp_path)
    assert "component hand_1: fmu hand, FMI 3, sha256 " in done.stderr
    quiet = cohaptic("run", "single_user", *SHORT, "--log-file", "l", folder=tmp_path)
    assert quiet.stderr == ""
    assert "component hand_1: fmu hand" in (tmp_path / "l").read_text()
    wrong = cohaptic(
        "run", "single_user", "--set", "duration=x", "--log-file", "l", folder=tmp_path
    )
    assert wrong.returncode == 2
    assert wrong.stderr.count("'x' is not a number with a unit") == 1
    assert "'x' is not a number with a unit" in (tmp_path / "l").read_text()


def test_check_reads_several_and_says_all_that_is_wrong(tmp_path: Path) -> None:
    good = cohaptic("check", *TWO, "--json", folder=tmp_path)
    assert [each["name"] for each in json.loads(good.stdout)["scenarios"]] == list(TWO)
    bad = cohaptic("check", "nowhere", "single_user", "thesis/elsewhere", folder=tmp_path)
    assert bad.returncode == 2
    assert "nowhere" in bad.stderr
    assert "thesis/elsewhere" in bad.stderr


@pytest.mark.parametrize("arguments", [("check",), ("run", *SHORT)])
@pytest.mark.parametrize("scenario", ["two_users_box", "thesis/three_users"])
def test_a_terminal_of_40_columns_is_enough(
    scenario: str, arguments: tuple[str, ...], tmp_path: Path
) -> None:
    shown = at_a_terminal(40, [*arguments, scenario], tmp_path)
    widest = max(shown.splitlines(), key=len)
    assert len(widest) <= 40, widest
    whole = cohaptic(*arguments, scenario, folder=tmp_path).stdout
    numbers = set(re.findall(r"\S+_\S+", whole)) - {"_"}
    assert numbers
    assert not [name for name in numbers if name not in shown and "runs/" not in name]


ANY = st.text(max_size=20)


@given(name=ANY, message=ANY, label=ANY, value=st.none() | st.floats(allow_nan=False))
def test_any_text_gives_xml_that_can_be_read(
    name: str, message: str, label: str, value: float | None
) -> None:
    verdict = {"target": name, "label": label, "predicate": "below", "threshold": 1.0, "unit": "N"}
    content = {"status": 1, "message": message, "run": name}
    content |= {
        "expectations": [
            {**verdict, "measured": value, "passed": False, "lacking": message or None}
        ]
    }
    root = ET.fromstring(junit([RunEnd(name, content), RunEnd(name, None, RunError(message))]))
    assert root.get("tests") == "3"
    assert len(list(root.iter("failure"))) == int(root.get("failures") or 0) == 1
    assert len(list(root.iter("error"))) == int(root.get("errors") or 0)
