"""A driver in a package of its own is complete with one folder and one entry point.

It is installed beside cohaptic, which knows nothing of it, and every command is run on it.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hil.setup.device_file import DeviceFile
from hil.wire.side_channel import Control
from tests.support.installed_package import ROOT, install

PACKAGE = ROOT / "tests/outside/lab_board"
CLI = "from cosim.cli import main; main()"
PORT = """
from types import SimpleNamespace
from serial.tools import list_ports
list_ports.comports = lambda: [
    SimpleNamespace(vid=0x1209, pid=0x0001, device="/dev/ttyACM7", description="lab", hwid="x")
]
"""
SCENARIO = {
    "cohaptic": 1,
    "duration": 4,
    "rates": {"control": 1024},
    "components": {
        "finger": {"device": {"url": "", "file": "device.yaml"}, "rate": "control"},
        "push": {"python": "tests.support.hil.pushing:Push", "rate": "control"},
    },
    "connections": ["push.motor_torque -> finger.motor_torque"],
    "record": ["finger.*"],
}


class Installed:
    """The package, and commands that are run with it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = install(PACKAGE, folder / "packages")

    def command(self, *arguments: str, before: str = "", status: int = 0) -> str:
        done = subprocess.run(
            [sys.executable, "-c", before + CLI, *arguments],
            env=self.environment,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == status, (done.stdout + done.stderr)[-1500:]
        return done.stdout + done.stderr

    @contextmanager
    def emulator(self, *options: str) -> Iterator[str]:
        """The URL of ``cohaptic device emulate lab``, which runs meanwhile."""
        process = subprocess.Popen(
            [sys.executable, "-c", CLI, "device", "emulate", "lab", *options],
            env=self.environment,
            cwd=self.folder,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        try:
            yield json.loads(process.stdout.readline())["url"]
        finally:
            process.stdout.close()
            process.terminate()
            process.wait(10)


@pytest.fixture
def lab(tmp_path) -> Installed:
    return Installed(tmp_path)


def test_cohaptic_itself_does_not_know_it():
    for folder in ("cosim", "hil", "cohaptic"):
        for file in (ROOT / folder).rglob("*.py"):
            assert "lab_board" not in file.read_text("utf-8"), file
    assert DeviceFile  # the product is the one of this tree


def test_it_is_listed_and_found(lab: Installed):
    listed = json.loads(lab.command("device", "list", "--json"))["lab"]
    assert listed["description"].startswith("``lab:///dev/ttyACM0``")
    assert listed["latency_ticks"] == 1
    assert listed["emulated"]
    assert listed["command_unit"] == "N.m"
    assert listed["presets"] == ["lab"]
    found = lab.command("device", "find", before=PORT)
    assert "lab:///dev/ttyACM7" in found
    assert "haply:///dev/ttyACM7" not in found, "its USB number is known"


def test_it_is_checked_calibrated_and_homed_on_its_emulator(lab: Installed):
    with lab.emulator("--lockstep", "--file", "device.yaml") as url:
        seen = lab.command("device", "check", url, "--seconds", "0.3", "--json")
        assert json.loads(seen.splitlines()[0])["fault"] is None
        (lab.folder / "device.yaml").write_text(
            (lab.folder / "device.yaml").read_text() + "settings: {full_scale: 150 mN.m}\n"
        )
        lab.command("device", "calibrate", url, "device.yaml", "--enable-output", "--yes")
        proof = lab.command(
            *("device", "check", url, "--file", "device.yaml", "--seconds", "0.2"),
            *("--enable-output", "--yes"),
        )
        assert "watchdog of 20 ms was reported to have fired" in proof
        assert "tip at 25.0, 140.0 mm" in lab.command(
            "device", "home", url, "--file", "device.yaml", "--yes"
        )
    written = (lab.folder / "device.yaml").read_text()
    assert "full_scale: 150 mN.m" in written
    assert "preset: lab" in written


def test_it_runs_with_force_on_its_emulator(lab: Installed):
    with lab.emulator("--lockstep", "--file", "device.yaml") as url:
        scenario = json.loads(json.dumps(SCENARIO))
        scenario["components"]["finger"]["device"]["url"] = url
        (lab.folder / "scenario.yaml").write_text(json.dumps(scenario))
        assert "latency in ticks: 1" in lab.command("check", "scenario.yaml")
        lab.command("run", "scenario.yaml", "--out", "run", "--enable-output", "--yes")
        control = Control(url.partition("emulator=")[2].partition("&")[0])
        state = control.ask("state")
        control.close()
        assert state["largest"] == pytest.approx(0.02, abs=2e-6)
        assert state["torque"] == [0.0, 0.0]


def test_its_settings_are_its_own(lab: Installed):
    (lab.folder / "device.yaml").write_text("driver: lab\nsettings: {full_scael: 1}\n")
    said = lab.command("device", "check", "lab:///dev/none", "--file", "device.yaml", status=2)
    assert "Did you mean full_scale" in said


def test_it_conforms(lab: Installed):
    with lab.emulator("--lockstep", "--file", "device.yaml") as url:
        said = lab.command(
            *("device", "conform", url, "--file", "device.yaml", "--seconds", "0.5"),
            *("--enable-output", "--yes", "--json"),
        )
    rules = json.loads(said.splitlines()[0])["rules"]
    assert {rule["name"] for rule in rules if rule["outcome"] == "not tried"} == {"clock", "switch"}
    assert {rule["name"] for rule in rules if rule["outcome"] == "broken"} == set()
