"""A device in a scenario, over real bytes: the record is the simulation's, but for its encoders.

In lock-step nothing depends on a clock, so the bound is tight; the paced run is the same command
that a lab uses, on whatever machine the tests run on.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import RunError
from cosim.cli import cli
from cosim.record.reader import open_run
from cosim.scenario import load
from hil.device.errors import ActivationRefused
from hil.emulation.launch import Emulator, Order
from hil.setup.address import parse
from hil.setup.device_edit import save
from hil.setup.registry import find
from tests.support.hil.driver_bench import QUANSER
from tests.support.machine import timed

DURATION = "1.6 s"
TICKS = 1639
FREE_TICKS = 1000
COUNT = 2 * np.pi / 20000
RUN = ("run", "two_users_box", "--duration", DURATION, "--set", "expect=~", "--no-figure", "--json")
LIMITS = {"torque": 0.18, "continuous_torque": 0.18, "slew": 240.0, "tip_speed": 2.0}
FINGER, WORKSTATION = "finger_a1", "vr_a"


def emulated(*, lockstep: bool, name: str = "haply") -> Emulator:
    """A board that moves the very pantograph and operator that the scenario has."""
    scenario = load("two_users_box")
    pantograph = scenario.components[FINGER].parameters
    return Emulator(
        Order(
            name=name,
            lockstep=lockstep,
            priority=0 if lockstep else 65,
            parameters={**QUANSER, **pantograph},
            operator=scenario.components["operator_a1"].parameters,
        )
    )


def device_file(folder: Path, emulator: Emulator) -> Path:
    path = folder / "device.yaml"
    document = {
        "driver": parse(emulator.url).driver,
        "preset": "quanser",
        "home": list(emulator.home),
        "limits": LIMITS,
        "motor": {"continuous_torque": 0.2},
    }
    document["loosened"] = dict.fromkeys(document["limits"], "an emulator hurts nobody")
    save(path, document)
    return path


def attempt(folder: Path, *options: str) -> tuple[int, dict]:
    done = CliRunner().invoke(
        cli,
        [*RUN, *options, "--out", str(folder)],
        catch_exceptions=False,
        standalone_mode=False,
    )
    return done.exit_code, json.loads(done.stdout)


def run(folder: Path, *options: str) -> dict:
    status, summary = attempt(folder, *options)
    assert status == 0, summary["message"]
    return summary


def swapped(folder: Path, emulator: Emulator) -> list[str]:
    mapping = f"{{url: '{emulator.url}', file: '{device_file(folder, emulator)}'}}"
    return [
        *("--set", f"components.{FINGER}.device={mapping}"),
        *("--set", "components.operator_a1=~"),
        *("--enable-output", "--yes"),
    ]


def signal(folder: Path, name: str) -> np.ndarray:
    with open_run(folder) as record:
        return np.asarray(record[name].values)


TWIN = f"""
components:
  finger_a1: {{parameters: {{computation_delay_ticks: %d}}}}
  safety: {{
    python: "hil.safety.component:Safety", station: station_a, rate: control, parameters: {LIMITS}
  }}
connections:
  - {{remove: finger_a1.device}}
  - finger_a1.joint_angle -> safety.joint_angle
  - vr_a.finger_1.motor_torque -> safety.command
  - safety.motor_torque -> finger_a1.motor_torque
"""
"""The simulated finger with what the device has besides: latency, and the safety layer."""


def simulate(folder: Path, latency: int) -> Path:
    folder.mkdir()
    (folder / "twin.yaml").write_text(TWIN % latency)
    run(folder / "run", "--with", str(folder / "twin.yaml"))
    return folder / "run"


@pytest.mark.parametrize("name", ["canopen", "haply"])
def test_in_lock_step_the_record_differs_by_resolution_and_latency_only(tmp_path, name):
    simulated = simulate(tmp_path / "simulated", find(name).latency_ticks)
    with emulated(lockstep=True, name=name) as emulator:
        run(tmp_path / "run", *swapped(tmp_path, emulator))
        state = emulator.control.ask("state")
        assert state["torque"] == [0.0, 0.0]
        assert state["largest"] > 0.01, "it has to push in between"
    finger = [
        signal(folder, "finger_a1.joint_angle[1]") for folder in (simulated, tmp_path / "run")
    ]
    apart = np.abs(finger[1] - finger[0])
    assert apart[:FREE_TICKS].max() < 2 * COUNT, "in free motion they are two counts apart at most"
    # From the first touch on, half a count is another moment of contact and another slide of the
    # fingertip: the bound is what that makes of the box in half a second.
    for axis, bound in (("x", 1.5e-3), ("y", 1.5e-3), ("theta", 0.02)):
        expected = signal(simulated, f"vr_a.box_pose.{axis}")
        found = signal(tmp_path / "run", f"vr_a.box_pose.{axis}")
        assert np.abs(found - expected).max() < bound, axis
    assert signal(simulated, "vr_a.finger_1.normal_force").max() > 0.5, "it has to touch the box"


def test_without_enable_output_no_motor_ever_moves(tmp_path):
    """The workstation computes its torques, the record keeps them, and the motors see none."""
    with emulated(lockstep=True, name="haply") as emulator:
        dry = [o for o in swapped(tmp_path, emulator) if o not in {"--enable-output", "--yes"}]
        run(tmp_path / "dry", *dry)
        assert emulator.control.ask("state")["largest"] == 0.0
    assert np.abs(signal(tmp_path / "dry", "vr_a.finger_1.motor_torque[1]")).max() > 0.01
    assert not signal(tmp_path / "dry", "finger_a1.applied_torque[1]").any()


def test_enable_output_without_a_confirmation_is_refused(tmp_path):
    with emulated(lockstep=True, name="haply") as emulator:
        options = [option for option in swapped(tmp_path, emulator) if option != "--yes"]
        with pytest.raises(ActivationRefused, match="nobody to confirm"):
            attempt(tmp_path / "refused", *options)
        assert emulator.control.ask("state")["largest"] == 0.0


@pytest.mark.parametrize("name", ["haply", "cobs", "odrive", "canopen", "cia402"])
def test_in_real_time_the_same_command_runs_on_the_clock(tmp_path, name):
    """A machine that stalls makes the run fault, as it has to: a sentence, and status 1.

    Haply's protocol allows 3 ms without an answer, an ODrive's data may be nine ticks old.
    """

    def paced(number: int) -> tuple[Path, dict] | str:
        folder = tmp_path / f"run{number}"
        try:
            with emulated(lockstep=False, name=name) as emulator:
                status, summary = attempt(folder, *swapped(tmp_path, emulator), "--realtime")
        except RunError as error:  # it faulted before the first tick
            status, summary = error.exit_status, {"message": str(error)}
        assert status in {0, 1}
        return (folder, summary) if status == 0 else summary["message"]

    folder, summary = timed(paced, tolerates=2e-3)
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["deadlines"]["ticks"] == summary["ticks"] == TICKS
    assert list(manifest["deadlines"]["latency_ticks"].values()) == [find(name).latency_ticks]
    assert np.isfinite(signal(folder, "vr_a.box_pose.y")).all()
    assert set(signal(folder, "finger_a1.status")) == {11}
