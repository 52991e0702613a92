"""A study of two conditions and eight trials each finds what was put into it, cut off or not."""

from __future__ import annotations

import csv
import json
import os
import pty
import select
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.support.command import COHAPTIC, cohaptic

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


class Terminal:
    """A person: reads what is asked and types."""

    def __init__(self, folder: Path, *more: str) -> None:
        self.ours, theirs = pty.openpty()
        command = [*COHAPTIC, "study", "plan.yaml", "--participant", "H1", "--no-realtime", *more]
        self.process = subprocess.Popen(
            command, cwd=folder, stdin=theirs, stdout=theirs, stderr=theirs
        )
        os.close(theirs)
        self.said = ""

    def listen_for(self, text: str) -> None:
        end = time.monotonic() + 60
        while text not in self.said:
            assert time.monotonic() < end, self.said
            if select.select([self.ours], [], [], 0.1)[0]:
                self.said += os.read(self.ours, 4096).decode(errors="replace")
        self.said = self.said.partition(text)[2]

    def type(self, text: str) -> None:
        time.sleep(0.05)  # after the flush of what was typed ahead
        os.write(self.ours, text.encode())


def test_a_person_answers_leaves_and_comes_back(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN)
    sitting = Terminal(tmp_path)
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
    again = Terminal(tmp_path)
    again.listen_for("H1 goes on after 1 of 16 trials.")
    again.listen_for("Trial 2 of 16.")
    again.process.kill()
    again.process.wait()
    person = tmp_path / "studies" / "plan" / "people" / "H1"
    head, first = (json.loads(line) for line in (person / "log.jsonl").read_text().splitlines())
    assert head["emulated"] is False
    assert first["answers"] == {"noticed": True, "comfort": 5.0}
    assert (person / "trial-002-cut-1").is_dir()


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
