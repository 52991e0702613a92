"""``cohaptic device``: the commands on an emulator in real time, and what they say of mistakes."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from hil.device.errors import DeviceGone
from hil.setup.device_file import load
from tests.support.hil.driver_bench import Bench


def invoke(*arguments: str):
    return CliRunner().invoke(
        cli, ["device", *arguments], catch_exceptions=False, standalone_mode=False
    )


def test_list_and_find_answer_without_a_device():
    listed = json.loads(invoke("list", "--json").stdout)
    assert {"mock", "haply", "odrive"} <= set(listed)
    assert listed["haply"]["latency_ticks"] == 1
    assert not listed["haply"]["tested_on_hardware"]
    assert "candidates" in json.loads(invoke("find", "--json").stdout)


def test_check_reads_and_commands_nothing(bench: Bench):
    emulator = bench.emulator("haply")
    done = invoke("check", emulator.url, "--seconds", "0.3", "--json")
    seen = json.loads(done.stdout)
    assert done.exit_code == 0
    assert seen["exchanges"] == 308
    assert 290 < seen["samples"] <= 308
    assert emulator.control.ask("state")["torque"] == [0.0, 0.0]


def test_calibrate_writes_a_file_that_home_takes(bench: Bench, tmp_path):
    emulator = bench.emulator("haply")
    path = tmp_path / "device.yaml"
    home = [str(angle) for angle in emulator.home]
    invoke("calibrate", emulator.url, str(path), "--home", *home, "--estop", "--yes")
    assert load(path).estop_confirmed
    done = invoke("home", emulator.url, "--file", str(path), "--yes")
    assert "tip at 19.0, 100.0 mm" in done.stdout


def test_mistakes_are_sentences():
    with pytest.raises(InputError, match="did you mean 'haply'"):
        invoke("check", "haplyy:///dev/x")
    with pytest.raises(DeviceGone, match="cannot be opened"):
        invoke("check", "haply:///dev/does-not-exist")
    with pytest.raises(InputError, match="is for 'cobs' and 'force_sensor'"):
        invoke("emulate", "haply", "--firmware")
    with pytest.raises(InputError, match="there is no device driver 'spoon'"):
        invoke("emulate", "spoon")
