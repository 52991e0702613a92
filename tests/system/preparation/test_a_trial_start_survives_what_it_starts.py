"""A component that refuses, hangs or crashes at its start gives a sentence with its place."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError, RunError
from cosim.cli import cli
from cosim.preparation.prepare import prepare
from cosim.preparation.trial_start import try_to_start
from cosim.scenario import load

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
    with pytest.raises(InputError, match="guest hangs: being initialised has not ended"):
        start(tmp_path, "hangs", "time.sleep(60)", 0.5)


@pytest.mark.parametrize(
    ("name", "body", "how"),
    [
        ("crashes", "faulthandler.disable(); os.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV"),
        ("leaves", "os._exit(3)", "exit status 3"),
    ],
)
def test_one_that_takes_its_process_down(tmp_path: Path, name: str, body: str, how: str) -> None:
    with pytest.raises(InputError) as refused:
        start(tmp_path, name, body)
    assert f"guest ended its process ({how}) while being initialised" in str(refused.value)
    assert refused.value.location is not None
    assert (refused.value.location.line, Path(refused.value.location.file).name) == (5, "s.yaml")


def test_one_that_fails_is_the_runs_own_error(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="guest failed while it was initialised: ValueError: no"):
        start(tmp_path, "fails", "raise ValueError('no')")


def test_a_device_is_not_opened() -> None:
    result = CliRunner().invoke(
        cli,
        [
            *("check", "single_user", "--json", "--set", "components.finger_1.fmu=~"),
            *("--set", "components.finger_1.device=haply:///dev/there-is-no-such-port"),
        ],
    )
    assert "cannot be opened" not in result.output + str(result.exception)
