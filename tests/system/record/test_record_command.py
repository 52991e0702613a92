"""``cohaptic record`` looks into runs of any ending."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli.record import command


def invoke(*arguments: object) -> str:
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


def test_equal_runs_have_equal_digests(small_run: Path) -> None:
    first, second = invoke("digest", small_run, small_run / "run.h5").splitlines()
    assert first.split()[0] == second.split()[0]
    content = json.loads(invoke("digest", small_run, "--json"))
    assert content["digests"] == {str(small_run): first.split()[0]}


def test_the_list_has_rates_units_and_descriptions(small_run: Path) -> None:
    text = invoke("list", small_run)
    assert "control: 1024 Hz, 2048 rows" in text
    assert "a.ramp" in text
    assert "a ramp" in text
    content = json.loads(invoke("list", small_run, "--json"))
    assert content["groups"]["network"]["signals"]["lan.held"]["unit"] == "m/s"


def test_a_run_without_a_summary_gets_one_from_its_record(small_run: Path) -> None:
    content = json.loads(invoke("summary", small_run, "--json"))
    assert content["status"] == 1
    assert content["message"] == "The run was cut off."
    assert content["signals"]["a.ramp"]["maximum"] == pytest.approx(2.047)
    assert content["signals"]["a.state"]["changes"] == 3
    assert "a.sine" in invoke("summary", small_run)


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a run folder"):
        CliRunner().invoke(command, ["digest", str(tmp_path)], catch_exceptions=False)


def test_compact_says_what_it_did(small_run: Path) -> None:
    assert "nothing was cut" in invoke("compact", small_run)
