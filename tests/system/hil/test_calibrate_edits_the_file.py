"""``cohaptic device calibrate`` changes what it measures, keeps the rest, and asks first."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from hil.device.errors import ActivationRefused
from hil.setup.calibrate.turner import EMULATED_TURN
from hil.setup.device_file import load
from hil.wire.side_channel import Control
from tests.support.hil.driver_bench import Bench
from tests.support.hil.motor_process import motors

BEFORE = """\
# The one by the window.
cohaptic_device: 1
driver: haply
preset: haply
serial: "5573"
estop: confirmed  # Ada, 2026
home: [{0!r}, {1!r}]
joints:
  - {{direction: -1, counts_per_turn: 4880, drive: {{gear: 1.0, direction: {2}}}}}
  - {{counts_per_turn: 4880, offset: 0.25}}
limits: {{torque: 0.1}}  # it is a light one
workspace: {{left: -0.04, right: 0.08, bottom: 0.05, top: 0.15}}
settings: {{ports: [2, 1]}}
"""


def invoke(*arguments: str):
    return CliRunner().invoke(
        cli, ["device", *arguments], catch_exceptions=False, standalone_mode=False
    )


def written(tmp_path, emulator, *, motor: int = 1):
    path = tmp_path / "device.yaml"
    path.write_text(BEFORE.format(*emulator.home, motor))
    return path


def test_what_is_not_measured_stays(bench: Bench, tmp_path):
    emulator = bench.emulator("haply")
    path = written(tmp_path, emulator)
    said = invoke("calibrate", emulator.url, str(path), "--yes").stdout
    after = path.read_text()
    for line in BEFORE.format(*emulator.home, 1).splitlines():
        if "direction: -1" not in line and "offset" not in line:
            assert line in after, after
    file = load(path)
    assert [joint.direction for joint in file.joints] == [1, 1], "the encoder counts forwards"
    assert file.joints[1].offset == 0.25
    assert file.settings.ports == (2, 1)
    assert file.date is not None
    assert "-  - {direction: -1, counts" in said
    assert "+  - {direction: 1, counts" in said


@pytest.mark.parametrize("name", ["haply", "cobs"])
@pytest.mark.parametrize("motor", [1, -1])
def test_with_consent_the_sign_of_each_motor_is_seen(bench: Bench, tmp_path, name, motor):
    emulator = bench.emulator(name, hand={"stiffness": 60.0, "damping": 3.0})
    path = tmp_path / "device.yaml"
    path.write_text(
        json.dumps(
            {
                "driver": name,
                "home": list(emulator.home),
                "joints": [{"drive": {"direction": motor}}, {}],
                "watchdog_proof": {"date": "2026-03-01", "timeout": 0.02, "fired_after": 0.03},
            }
            if name == "cobs"
            else {
                "driver": name,
                "home": list(emulator.home),
                "joints": [{"drive": {"direction": motor}}, {}],
            }
        )
    )
    invoke("calibrate", emulator.url, str(path), "--enable-output", "--yes")
    assert [joint.drive.direction for joint in load(path).joints] == [1, 1]
    state = emulator.control.ask("state")
    assert state["torque"] == [0.0, 0.0]
    assert 0.0 < state["largest"] < 0.041


def test_a_person_is_asked_and_the_file_waits_for_the_word(bench: Bench, tmp_path, monkeypatch):
    emulator = bench.emulator("haply", lockstep=False)
    path = written(tmp_path, emulator)
    before, asked, answer = path.read_text(), [], "no"

    def person(text: str) -> str:
        asked.append(text)
        turn = [EMULATED_TURN * (f"Turn joint {joint}" in text) for joint in (1, 2)]
        control = Control(emulator.control.path)
        control.ask("shift", by=turn)
        control.close()
        return answer

    monkeypatch.setattr("cosim.cli.support.devices.person_or_emulator", lambda *_, **__: person)
    with pytest.raises(InputError, match="stays as it was"):
        invoke("calibrate", emulator.url, str(path))
    assert path.read_text() == before
    answer = "write"
    invoke("calibrate", emulator.url, str(path))
    assert load(path).joints[0].direction == 1
    assert len([text for text in asked if text.startswith("Turn joint")]) == 4
    assert asked[-1].startswith("Type 'write'")


@pytest.mark.parametrize("command", ["home", "calibrate"])
@pytest.mark.parametrize("options", [(), ("--yes",)])
def test_without_a_person_nothing_but_an_emulator_is_homed(tmp_path, command, options):
    with motors("haply") as board:
        path = tmp_path / "device.yaml"
        path.write_text("driver: haply\nhome: [2.427, 0.714]\n")
        url = f"haply://{board.port}"
        arguments = [url, str(path)] if command == "calibrate" else [url, "--file", str(path)]
        with pytest.raises(ActivationRefused, match="did not prove to be an emulator"):
            invoke(command, *arguments, *options)
        assert "date" not in path.read_text()


def test_a_new_file_needs_a_home_pose(tmp_path):
    with pytest.raises(InputError, match="--home: give the joint angles"):
        invoke("calibrate", "haply:///dev/none", str(tmp_path / "new.yaml"))
