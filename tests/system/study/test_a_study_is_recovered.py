"""A study of two conditions and eight trials each finds what was put into it, cut off or not."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import time
from pathlib import Path

import pytest

from cosim.study.questions import NASA_TLX
from tests.support.command import COHAPTIC, cohaptic
from tests.support.terminal import Terminal

INJECTED = {"weak": 6.0, "strong": 3.0}
PLAN = """\
study: 1
title: From which delay on is a trembling noticed?
scenario: single_axis_distributed
set: [duration=0.02]
seed: 5
conditions:
  weak: {set: [components.coupler_o1.parameters.stiffness=300]}
  strong: {set: [components.coupler_o1.parameters.stiffness=600]}
trials: 8
staircase:
  {vary: lan.round_trip_delay, least: 0, most: 16, start: 8, steps: [4, 2, 1], answer: noticed}
questions:
  noticed: {ask: "Did the object tremble?"}
  comfort: {ask: "How comfortable was it?", kind: scale, least: 1, most: 7}
after_condition: [nasa_tlx]
emulated: {threshold: {weak: 6, strong: 3}, slope: 2}
"""
TIMES = {"shown_seconds", "answered_seconds", "started"}


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "studies" / "plan" / "trials.csv").open() as file:
        return [{k: v for k, v in row.items() if k not in TIMES} for row in csv.DictReader(file)]


def emulate(folder: Path, code: str) -> None:
    done = cohaptic("study", "plan.yaml", "--participant", code, "--emulate", folder=folder)
    assert done.returncode == 0, done.stderr


def tabulated(folder: Path) -> dict[str, dict[str, dict[str, float]]]:
    done = cohaptic("study", "table", "plan.yaml", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["thresholds"]


@pytest.fixture(name="whole", scope="module")
def _whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    (folder / "plan.yaml").write_text(PLAN)
    for code in ("P01", "P02"):
        emulate(folder, code)
    return folder


def test_the_injected_thresholds_lie_in_their_intervals(whole: Path) -> None:
    found = tabulated(whole)
    for condition, injected in INJECTED.items():
        every = found[condition]["all"]
        assert every["trials"] == 16
        assert every["low"] <= injected <= every["high"], condition
        assert every["high"] - every["low"] < 8, "an interval that holds everything says nothing"
    rows = table(whole)
    assert len(rows) == 32
    assert [row["condition"] for row in rows[::8]] == ["weak", "strong", "strong", "weak"]
    runs = whole / "studies" / "plan"
    assert all((runs / row["run"] / "run.h5").is_file() for row in rows)
    delays = {
        json.loads((runs / row["run"] / "manifest.json").read_text())["scenario"]["seed"]
        for row in rows
    }
    assert len(delays) == 32, "each trial has a seed of its own"


def test_killed_anywhere_it_goes_on_without_loss(whole: Path, tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN)
    command = [*COHAPTIC, "study", "plan.yaml", "--participant", "P01", "--emulate"]
    log = tmp_path / "studies" / "plan" / "people" / "P01" / "log.jsonl"
    for steps in (3, 9):
        process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 60
        while not (log.exists() and log.read_bytes().count(b"\n") >= steps):
            assert time.monotonic() < end
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
    emulate(tmp_path, "P01")
    tabulated(tmp_path)
    tabulated(whole)
    assert table(tmp_path) == table(whole)[:16]


def test_an_excluded_participant_counts_no_more_and_stays_in_the_table(whole: Path) -> None:
    before = tabulated(whole)["weak"]["all"]["trials"]
    done = cohaptic(
        *("study", "exclude", "plan.yaml", "P02", "--trial", "9", "--reason", "slept"), folder=whole
    )
    assert done.returncode == 0, done.stderr
    after = tabulated(whole)
    rows = table(whole)
    assert [row["trial"] for row in rows if row["excluded"]] == ["9"]
    assert len(rows) == 32
    assert sum(after[c]["all"]["trials"] for c in after) == 2 * before - 1
    reason = ("--trial", "9", "--reason", "it was another one", "--by", "Ada")
    done = cohaptic("study", "include", "plan.yaml", "P02", *reason, folder=whole)
    assert done.returncode == 0, done.stderr
    assert tabulated(whole)["weak"]["all"]["trials"] == before
    assert not any(row["excluded"] for row in table(whole))
    done = cohaptic("study", "include", "plan.yaml", "P02", *reason, folder=whole)
    assert done.returncode == 2
    assert "nothing to take back" in done.stderr


class Sitting(Terminal):
    """A participant."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "study", "plan.yaml", "--participant", "H1", "--no-realtime")

    def answer(self, trial: int) -> None:
        self.listen_for(f"Trial {trial} of")
        self.listen_for("tremble? (y/n): ")
        self.type("y\n")
        self.listen_for("(1 … 7): ")
        self.type("5\n")


def test_a_person_answers_leaves_and_comes_back(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN)
    sitting = Sitting(tmp_path)
    sitting.listen_for("Did the object tremble? (y/n): ")
    sitting.type("perhaps\n")
    sitting.listen_for("Answer y or n.")
    sitting.listen_for("tremble? (y/n): ")
    sitting.type("y\n")
    sitting.listen_for("(1 … 7): ")
    sitting.type("9\n")
    sitting.listen_for("a whole number from 1 to 7")
    sitting.listen_for("(1 … 7): ")
    sitting.type("5\n")
    sitting.listen_for("tremble? (y/n): ")
    sitting.type("\x04")
    sitting.listen_for("The session is left")
    assert sitting.process.wait(20) == 1
    again = Sitting(tmp_path)
    again.listen_for("H1 goes on after 1 of 16 trials.")
    again.listen_for("Trial 2 of 16.")
    again.kill()
    person = tmp_path / "studies" / "plan" / "people" / "H1"
    head, first = (json.loads(line) for line in (person / "log.jsonl").read_text().splitlines())
    assert head["emulated"] is False
    assert first["answers"] == {"noticed": True, "comfort": 5.0}
    assert (person / "trial-002-cut-1").is_dir()


def test_interrupted_in_a_break_it_says_how_to_go_on(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(f"{PLAN}break: {{every: 1, least: 1 min}}\n")
    sitting = Sitting(tmp_path)
    sitting.answer(1)
    sitting.listen_for("Rest for 60 s.")
    sitting.process.send_signal(signal.SIGINT)
    sitting.listen_for("The session is left; the same command goes on")
    assert sitting.process.wait(20) == 1


@pytest.mark.slow
def test_killed_in_a_question_a_break_and_a_trial_a_person_goes_on(tmp_path: Path) -> None:
    plan = PLAN.replace("trials: 8", "trials: 2").replace("[duration=0.02]", "[duration=2]")
    (tmp_path / "plan.yaml").write_text(f"{plan}break: {{every: 1}}\n")
    person = tmp_path / "studies" / "plan" / "people" / "H1"

    sitting = Sitting(tmp_path)
    sitting.listen_for("tremble? (y/n): ")
    sitting.kill()
    sitting = Sitting(tmp_path)
    sitting.answer(1)
    sitting.listen_for("Press Enter to go on: ")
    sitting.kill()
    sitting = Sitting(tmp_path)
    sitting.listen_for("H1 goes on after 1 of 4 trials.")
    sitting.listen_for("Press Enter to go on: ")
    sitting.type("\n")
    sitting.listen_for("Trial 2 of 4.")
    end = time.monotonic() + 20
    while not (person / "trial-002" / "run.h5").exists():
        assert time.monotonic() < end
        time.sleep(0.01)
    sitting.kill()
    sitting = Sitting(tmp_path)
    for number in (2, 3, 4):
        sitting.answer(number)
        if number % 2 == 0:
            for asked in NASA_TLX.values():
                sitting.listen_for(asked.ask)
                sitting.listen_for("): ")
                sitting.type("35\n")
        if number < 4:
            sitting.listen_for("Press Enter to go on: ")
            sitting.type("\n")
    assert sitting.process.wait(20) == 0
    head, *steps = (json.loads(line) for line in (person / "log.jsonl").read_text().splitlines())
    assert [next(iter(step)) for step in steps] == [
        *("trial", "rest", "trial", "form", "rest", "trial", "rest", "trial", "form")
    ]
    assert [step["trial"] for step in steps if "trial" in step] == [1, 2, 3, 4]
    assert [step["condition"] for step in steps if "trial" in step] == head["order"]
    assert (person / "trial-001-cut-1").is_dir()
    assert (person / "trial-002-cut-1").is_dir()
    assert not (person / "trial-003-cut-1").exists()


def test_without_a_terminal_nobody_is_asked(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN)
    done = cohaptic("study", "plan.yaml", "--participant", "H1", folder=tmp_path)
    assert done.returncode == 2
    assert "need a terminal" in done.stderr
    assert not (tmp_path / "studies").exists()


def test_what_is_wrong_with_a_condition_is_said_before_anybody_waits(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN.replace("coupler_o1", "coupler_x"))
    done = cohaptic("study", "plan.yaml", "--participant", "P1", "--emulate", folder=tmp_path)
    assert done.returncode == 2
    assert "coupler_x" in done.stderr
    assert not (tmp_path / "studies").exists()
