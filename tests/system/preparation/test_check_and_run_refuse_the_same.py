"""Over all broken inputs: the same sentences at the same places, status 2, one object on stdout."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError
from cosim.cli import cli
from tests.support.broken_inputs import BASE, Case, cases, place

CASES = cases()
MAIN = (sys.executable, "-c", "from cosim.cli import main; main()")


def ask(command: str, file: Path, case: Case, *more: str) -> tuple[int, dict[str, Any]]:
    """Exit status and the object on stdout."""
    arguments = [command, str(file), "--json", *more]
    for text in case.sets:
        arguments += ["--set", text]
    if case.overlay is not None:
        overlay = file.with_name("over.yaml")
        overlay.write_text(case.overlay, encoding="utf-8")
        arguments += ["--with", str(overlay)]
    if command == "run":
        arguments += ["--no-figure", "--out", str(file.parent / "run")]
    done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    status = done.exit_code
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        assert isinstance(done.exception, CohapticError), repr(done.exception)
        status = done.exception.exit_status
    return status, json.loads(done.stdout)


def sentences(answer: dict[str, Any]) -> set[tuple[Any, ...]]:
    assert answer["ok"] is False
    return {(p["file"], p["line"], p["column"], p["message"]) for p in answer["problems"]}


def test_there_are_enough() -> None:
    assert len(CASES) >= 150
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_check_and_run_refuse_it_alike(case: Case, tmp_path: Path) -> None:
    file = place(tmp_path, case.text, case.files)
    checked = ask("check", file, case)
    ran = ask("run", file, case)
    assert checked[0] == ran[0] == 2, (checked, ran)
    assert sentences(checked[1]) == sentences(ran[1])
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    "case", {(c.right, *c.right_files): c for c in CASES}.values(), ids=lambda c: c.name
)
def test_its_valid_sibling_passes_both(case: Case, tmp_path: Path) -> None:
    file = place(tmp_path, case.right, case.right_files)
    plain = Case(case.name, case.right, case.right)
    assert ask("check", file, plain)[0] == 0
    assert ask("run", file, plain)[0] == 0


@pytest.mark.parametrize("case", CASES[::12], ids=lambda case: case.name)
def test_a_station_refuses_what_the_check_refuses(case: Case, tmp_path: Path) -> None:
    if case.right != BASE:
        pytest.skip("of one station")
    file = place(tmp_path, case.text, case.files)
    checked = ask("check", file, case)
    asked = ("--as", "a", "--peer", "127.0.0.1:1", "--wait", "0.1")
    status, answer = ask("station", file, case, *asked)
    assert status == 2
    assert sentences(answer) == sentences(checked[1])


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("number", [3, 60, 120])
def test_as_a_process(command: str, number: int, tmp_path: Path) -> None:
    case = [each for each in CASES if not each.sets and each.overlay is None][number]
    file = place(tmp_path, case.text, case.files)
    done = subprocess.run(
        [*MAIN, command, str(file), "--json"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert json.loads(done.stdout)["ok"] is False
    assert done.stderr.strip()
    assert "Traceback" not in done.stderr
