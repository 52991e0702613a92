"""A component that refuses, hangs or crashes at its start gives a sentence with its place."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError, InputError, RunError
from cosim.cli import cli
from cosim.preparation.prepare import prepare
from cosim.preparation.trial_start import try_to_start
from cosim.scenario import load
from tests.support.fmus.dying import command, dying

COMPONENT = """
import faulthandler, os, signal, time
from cosim.base.component import Component


class Stranger(Component):
    @property
    def variables(self):
        return ()

    def initialise(self, setup, inputs, outputs):
        {body}
"""
SCENARIO = """\
cohaptic: 1
duration: 1 s
components:
  hand: {fmu: hand, rate: 1024}
  guest: {python: "stranger_%s:Stranger", rate: 1024}
record: [hand.position]
"""


def start(folder: Path, name: str, body: str, seconds: float = 5.0) -> None:
    text = textwrap.dedent(COMPONENT).format(body=body)
    (folder / f"stranger_{name}.py").write_text(text)
    file = folder / "s.yaml"
    file.write_text(SCENARIO % name)
    with prepare(load(file)).simulation as simulation:
        try_to_start(simulation, seconds)


def test_a_start_that_works_says_nothing(tmp_path: Path) -> None:
    start(tmp_path, "works", "pass")


def test_one_that_hangs(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match="guest hangs in its initialisation before the first tick: not over"
    ):
        start(tmp_path, "hangs", "time.sleep(60)", 0.5)


@pytest.mark.parametrize(
    ("name", "body", "how"),
    [
        (
            "crashes",
            "faulthandler.disable(); os.kill(os.getpid(), signal.SIGSEGV)",
            "crashed (SIGSEGV: segmentation fault)",
        ),
        ("leaves", "os._exit(3)", "ended the process (exit status 3)"),
    ],
)
def test_one_that_takes_its_process_down(tmp_path: Path, name: str, body: str, how: str) -> None:
    with pytest.raises(InputError) as refused:
        start(tmp_path, name, body)
    assert f"guest {how} in its initialisation before the first tick" in str(refused.value)
    assert refused.value.location is not None
    assert (refused.value.location.line, Path(refused.value.location.file).name) == (5, "s.yaml")


CALLS = ["Instantiate", "SetString", "EnterInitializationMode", "ExitInitializationMode"]


@pytest.mark.parametrize("keys", ["", ", isolate: process"])
@pytest.mark.parametrize("call", [*CALLS, "initial Get", "Terminate", "FreeInstance"])
def test_the_call_that_an_fmu_dies_in_is_named(tmp_path: Path, call: str, keys: str) -> None:
    command(tmp_path, dying(tmp_path, 3, call, "exit(0)"), keys=keys)
    name = {"Instantiate": "InstantiateCoSimulation", "initial Get": ""}.get(call, call)
    place = f"in fmi3{name} before the first tick" if name else "while its outputs were read"
    with (
        prepare(load(tmp_path / "test.yaml")).simulation as simulation,
        pytest.raises(CohapticError, match=rf"box ended the process \(exit status 0\) {place}"),
    ):
        try_to_start(simulation)


def test_one_that_fails_is_the_runs_own_error(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="guest failed while it was initialised: ValueError: no"):
        start(tmp_path, "fails", "raise ValueError('no')")


def test_a_device_is_not_opened(tmp_path: Path) -> None:
    """There is no such port: who opened it would fail."""
    device = '{url: "haply:///dev/there-is-no-such-port", preset: quanser}'
    bench = tmp_path / "bench.yaml"
    bench.write_text(f"components:\n  finger_a1: {{device: {device}}}\n  operator_a1: ~\n")
    result = CliRunner().invoke(cli, ["check", "two_users_box", "--json", "--with", str(bench)])
    assert result.exit_code == 0, result.output + str(result.exception)
    assert set(json.loads(result.stdout)["devices"]) == {"finger_a1"}
