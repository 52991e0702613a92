"""``import cohaptic`` runs FMUs in its own process: one that calls ``exit`` is a failure, told."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.fmus.dying import command, dying, sentence

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the sentences are Linux's")

BY_HAND = """
from cosim.master.run.simulation import assemble
from cosim.scenario import load
print("begun", flush=False)
with assemble(load("test.yaml")) as simulation:
    simulation.start()
    simulation.advance(8)
print("went on")
"""
WHOLE = "import cohaptic\nprint('begun')\ncohaptic.run('test.yaml', 'out', figure=False)\n"


def ended(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("code", [BY_HAND, WHOLE], ids=["advance", "run"])
@pytest.mark.parametrize("call", ["Instantiate", "ExitInitializationMode", "DoStep", "Terminate"])
def test_exit_0_is_told_with_its_place_and_is_no_success(
    tmp_path: Path, call: str, code: str
) -> None:
    command(tmp_path, dying(tmp_path, 3, call, "exit(0)"))
    where = sentence(call, 3)[0].partition(";")[0]
    done = ended(tmp_path, code)
    assert done.returncode == 1
    assert f"box ended this process by exit() {where}" in done.stderr
    assert "isolate: process" in done.stderr
    assert done.stdout == "begun\n"  # what was printed before is not lost


def test_what_it_had_said_is_in_the_sentence(tmp_path: Path) -> None:
    says = 'say(m, 3, "the licence has expired"), exit(0)'
    command(tmp_path, dying(tmp_path, 3, "DoStep", says))
    assert "; it said: the licence has expired; its status is 1" in ended(tmp_path, BY_HAND).stderr


def test_the_end_of_the_process_is_its_own_when_no_fmu_is_called(tmp_path: Path) -> None:
    """Nothing is left to be called then, also after runs, and in forks."""
    command(tmp_path, dying(tmp_path, 3, "never", "exit(0)"))
    code = f"{BY_HAND}\nimport os, sys\nif os.fork() == 0:\n    sys.exit(3)\n"
    done = ended(tmp_path, f"{code}print(os.waitstatus_to_exitcode(os.wait()[1]))\nsys.exit(7)\n")
    assert (done.returncode, done.stderr) == (7, "")
    assert done.stdout.endswith("went on\n3\n")


def test_isolated_it_is_an_error_that_can_be_caught(tmp_path: Path) -> None:
    command(tmp_path, dying(tmp_path, 3, "DoStep", "exit(0)"), keys=", isolate: process")
    code = f"from cosim.base.errors import RunError\ntry:\n{_indented(BY_HAND)}\n"
    done = ended(tmp_path, f"{code}except RunError as error:\n    print(error)\n")
    assert done.returncode == 0, done.stderr
    assert "box ended the process (exit status 0) in its step at tick 3 (3 s)" in done.stdout


def _indented(code: str) -> str:
    return "".join(f"    {line}\n" for line in code.splitlines())
