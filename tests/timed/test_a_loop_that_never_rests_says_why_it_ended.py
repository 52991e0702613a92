"""The system kills a real-time loop that does not rest; the sentence knows of it.

What comes behind the last tick has no deadline: the loop is no real-time process any more.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.fmus.foreign import foreign_fmu, scalar

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the limit is Linux's")

SPINS = """
import os, time
from cosim.base.component import *

class Spins(Component):
    variables = (Variable(name="y", causality=Causality.OUTPUT, type=VariableType.FLOAT64),)
    def initialise(self, setup, inputs, outputs):
        self.outputs = outputs
    def evaluate(self, tick):
        self.outputs["y"][0] = tick
        end = time.monotonic() + (0.4 if tick == 200 and SECONDS else 0.0)
        while time.monotonic() < end:
            pass
"""


POLICY = """
    int sched_getscheduler(int process);
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep") && m->real[1]++ == 9)
            say(m, 1, sched_getscheduler(0) ? "steps in real time" : "steps as any process");
        if (is(call, "Terminate"))
            say(m, 1, sched_getscheduler(0) ? "ends in real time" : "ends as any process");
        return 0;
    }
    #define HOOK hook
"""


def ran(folder: Path, seconds: str, component: object = None) -> subprocess.CompletedProcess[str]:
    (folder / "spins.py").write_text(SPINS.replace("SECONDS", seconds))
    file = folder / "spins.yaml"
    file.write_text(
        json.dumps(
            {
                "cohaptic": 1,
                "duration": 0.5,
                "rates": {"control": "1024 Hz"},
                "components": {"it": component or {"python": "spins.py:Spins"}},
            }
        )
    )
    words = [sys.executable, "-c", "from cosim.cli import main; main()"]
    return subprocess.run(
        [*words, "run", str(file), "--realtime", "--no-figure", "--out", str(folder / "out")],
        cwd=folder,
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
    )


def is_granted(folder: Path) -> bool:
    """Whether this machine gives real-time priority at all: a run that ends well says so."""
    manifest = json.loads((folder / "out" / "manifest.json").read_text())
    return "SCHED_FIFO" in json.dumps(manifest) and "no real-time priority" not in json.dumps(
        manifest
    )


def test_the_sentence_says_that_the_loop_did_not_rest(tmp_path: Path) -> None:
    well, ill = tmp_path / "well", tmp_path / "ill"
    well.mkdir()
    ill.mkdir()
    assert ran(well, "0").returncode == 0
    done = ran(ill, "1")
    if is_granted(well):
        assert done.returncode == 1
        assert "did not rest for 100 ms" in done.stderr
    else:
        assert done.returncode == 0, "nothing limits a loop without priority"


def test_behind_the_last_tick_the_loop_is_as_any_process(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, scalar(3, "y", 1, causality="output"), snippet=POLICY)
    done = ran(tmp_path, "0", {"fmu": str(path), "rate": "control"})
    assert done.returncode == 0, done.stderr
    log = (tmp_path / "out" / "fmu.log").read_text()
    assert "ends as any process" in log
    assert ("steps in real time" in log) == is_granted(tmp_path)
