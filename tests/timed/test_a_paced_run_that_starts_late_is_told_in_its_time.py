"""A run with a device that keeps pace and starts at 10 s: ticks, values and every time told.

The device is the simulated pantograph in the loop's own process, so that what it measures hangs on
its commands alone: the record is that of the run from 0 on, ten seconds later.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.record.reader import open_run
from tests.support.fmus.dying import dying
from tests.support.fmus.dying import ended as run_dying

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a paced run needs Linux here")
TICKS, RATE, START = 512, 1024, 10
PUSHED, TURNED = Fraction(1, 8), Fraction(1, 4)
"""When (s) after the start the force begins, and when it is turned."""


def written(folder: Path, start: int) -> Path:
    """A finger that is pushed from 0.125 s on, and otherwise from 0.25 s on."""
    file = folder / f"from_{start}.yaml"
    push = {"mode": "step", "amplitude": 0.02, "start_time": float(start + PUSHED)}
    document: dict[str, Any] = {
        "cohaptic": 1,
        "duration": TICKS / RATE,
        "start_time": start,
        "rates": {"control": f"{RATE} Hz"},
        "components": {
            "finger": {"device": "mock://"},
            "push": {"fmu": "signal", "parameters": push},
        },
        "connections": ["push.value -> finger.motor_torque[1]"],
        "events": [{"at": float(start + TURNED), "set": {"push.amplitude": 0.03}}],
    }
    file.write_text(json.dumps(document))
    return file


def command(*words: object) -> list[str]:
    return [sys.executable, "-c", "from cosim.cli import main; main()", *map(str, words)]


def paced(file: Path, out: Path, *options: str) -> list[str]:
    output = ("--realtime", "--enable-output", "--yes", "--no-figure")
    return command("run", file, "--out", out, *output, *options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("late")
    for start in (0, START):
        call = paced(written(folder, start), folder / str(start))
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    return folder


def test_ticks_and_times_are_its_own(folder: Path) -> None:
    with open_run(folder / str(START)) as late:
        assert (late.ticks, late.start_tick) == (TICKS, START * RATE)
        assert late.span == (START, START + TICKS / RATE)
        times = START + np.arange(TICKS) / RATE
        np.testing.assert_array_equal(late["finger.joint_angle[1]"].group.time, times)
        command_given = late["push.value"].values
        pushed, turned = int(PUSHED * RATE), int(TURNED * RATE)
        assert set(command_given[:pushed]) == {0.0}
        assert set(command_given[pushed:turned]) == {0.02}
        assert set(command_given[turned:]) == {0.03}
    manifest = json.loads((folder / str(START) / "manifest.json").read_text())
    assert manifest["exit"]["ticks"] == manifest["deadlines"]["ticks"] == TICKS
    assert manifest["deadlines"]["lost_rows"] == 0


def test_the_devices_values_are_those_of_the_run_from_0_on(folder: Path) -> None:
    with open_run(folder / "0") as soon, open_run(folder / str(START)) as late:
        assert np.ptp(late["finger.joint_angle[1]"].values) > 0, "it has to move"
        assert late["finger.applied_torque[1]"].values.max() > 0.004
        assert soon.signals.keys() == late.signals.keys()
        for name, values in soon.signals.items():
            np.testing.assert_array_equal(values.values, late[name].values, err_msg=name)


def test_it_is_replayed(folder: Path) -> None:
    call = command("replay", folder / str(START))
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert f"all {TICKS} ticks are the same" in done.stdout, done.stderr


def test_an_interruption_is_told_at_its_time(tmp_path: Path) -> None:
    call = paced(written(tmp_path, START), tmp_path / "out", "--duration", "60")
    process = subprocess.Popen(call, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 30
    while not (tmp_path / "out" / "run.h5").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    os.kill(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 1
    ticks = json.loads((tmp_path / "out" / "summary.json").read_text())["ticks"]
    assert f"at tick {ticks} of {60 * RATE} (t = {START + ticks / RATE:g} s)" in said


def test_an_fmu_that_dies_is_told_at_its_time(tmp_path: Path) -> None:
    fmu = dying(tmp_path, 3, "DoStep", "abort()", rate=100)
    done = run_dying(tmp_path, fmu, "--realtime", "--set", f"start_time={START}", rate=100)
    assert done.returncode == 1
    assert f"box crashed (SIGABRT: aborted) in its step at tick 0 ({START} s)" in done.stderr
