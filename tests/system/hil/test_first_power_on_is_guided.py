"""``cohaptic device first`` leads from a bare board to a complete device file."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from cosim.base.errors import RunError
from cosim.cli import cli
from hil.device.errors import ActivationRefused
from hil.setup.device_file import load
from hil.setup.doctor.note import bad
from tests.support.hil.driver_bench import Bench
from tests.support.hil.motor_process import motors


def invoke(*arguments: str):
    return CliRunner().invoke(
        cli, ["device", "first", *arguments], catch_exceptions=False, standalone_mode=False
    )


@pytest.mark.parametrize("name", ["cobs", "haply"])
def test_a_bare_board_has_a_complete_file_in_the_end(bench: Bench, tmp_path, name):
    emulator = bench.emulator(name, hand={"stiffness": 60.0, "damping": 3.0})
    path = tmp_path / "device.yaml"
    home = [str(angle) for angle in emulator.home]
    done = invoke(emulator.url, str(path), "--home", *home, "--estop", "--yes")
    assert done.exit_code == 0
    file = load(path)
    assert file.home is not None
    assert file.estop_confirmed
    assert (file.watchdog_proof is not None) == (name == "cobs")
    said = done.stderr
    assert [f"Step {n}" in said for n in (1, 2, 3, 4)] == [True, True, name == "cobs", True]
    assert "cohaptic run SCENARIO --realtime --enable-output" in done.stdout
    assert emulator.control.ask("state")["torque"] == [0.0, 0.0]


def test_a_real_board_needs_a_person(tmp_path):
    with motors("cobs") as board, pytest.raises(ActivationRefused, match="a person has to"):
        invoke(f"cobs://{board.port}", str(tmp_path / "device.yaml"), "--home", "2.3", "0.85")


def test_a_machine_that_is_not_fit_ends_it(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "hil.setup.doctor.machine.machine_notes", lambda: [bad("rtprio", "none is granted")]
    )
    with pytest.raises(RunError, match="none is granted"):
        invoke("cobs:///dev/none", str(tmp_path / "device.yaml"))
