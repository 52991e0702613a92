"""``cohaptic check``: text for people, JSON for programs, exit status 2 for a wrong scenario."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest
from click.testing import CliRunner

from cosim.cli.check import command
from cosim.scenario import load
from cosim.scenario.resolved import to_yaml
from cosim.scenario.source.find import bundled_names

SCENARIOS = [name for name in bundled_names() if "/" not in name]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(command, arguments)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_bundled_scenario_passes(name: str) -> None:
    result = run(name, "--json")
    assert result.exception is None, result.exception
    report = json.loads(result.stdout)
    scenario = load(name)
    assert report["ok"] is True
    assert report["ticks"] == scenario.ticks
    assert set(report["components"]) == set(scenario.components)
    assert report["lagging"] == []
    evaluated = {stage["component"] for stage in report["order"]}
    assert evaluated == set(scenario.components)
    assert len(report["packets"]) == 2 * len(scenario.channels)


def test_the_text_names_what_there_is() -> None:
    text = run("two_users_box").stdout
    for part in (
        "network  128 Hz   8 ticks",
        "finger_b2",
        "delay 8 ticks (1 sample)",
        "lan.forward",
    ):
        assert part in text
    order = text.split("Evaluation order within a tick")[1].split()
    assert order.index("finger_a1") < len(order) - order[::-1].index("vr_a")


def test_resolved_and_schema_are_printed_as_they_are() -> None:
    assert run("single_user", "--resolved").stdout == to_yaml(load("single_user"))
    assert json.loads(run("--schema").stdout)["title"] == "cohaptic scenario"


def test_problems_are_one_object_for_programs() -> None:
    result = run("single_user", "--set", "seed=x", "--set", "duration=soon", "--json")
    report = json.loads(result.stdout)
    assert report["ok"] is False
    assert [problem["file"] for problem in report["problems"]] == [
        "--set duration=soon",
        "--set seed=x",
    ]


def test_the_command_ends_with_status_2_and_sentences_on_stderr() -> None:
    done = subprocess.run(
        [
            *(sys.executable, "-c", "from cosim.cli import main; main()"),
            *("check", "single_user", "--set", "components.hand_1.parameters.mas=1"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == (
        "--set components.hand_1.parameters.mas=1: hand_1 has no parameter 'mas'. "
        "Did you mean mass?\n"
    )
