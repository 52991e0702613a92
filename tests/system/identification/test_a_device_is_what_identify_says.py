"""From a device file to a preset: an emulated Haply, through its own bytes and the safety layer.

The emulator integrates the pantograph FMU, whose equations nobody here has written: it is the
oracle. In lock-step, so that a busy machine changes nothing. Tolerances first.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cohaptic
from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import inertia_matrix
from cosim.record import open_run
from hil.emulation.launch import Emulator, Order
from hil.emulation.mechanics import HeldForm, Mechanics
from hil.setup.device_edit import save
from tests.support.identification.known import HAPLY, HOME

INERTIA, COULOMB, GAIN = 0.02, 0.02, 0.02
LATENCY_TICKS = 0.1
OFFSET = 3e-3
PAYLOAD = 0.05
OFFSETS = (0.01, -0.01)
TRUE_GAIN = (1.05, 0.95)
MADE_OF = {"coulomb_friction": 0.005, "tip_mass": 0.018}
VALUES = Nominal.of("haply", MADE_OF).values(HAPLY)


def command(*arguments: str) -> tuple[int, str]:
    """Exit status and standard output."""
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    return done.exit_code, done.stdout


def excited(folder: Path, payload: float, seconds: str, gain=TRUE_GAIN) -> Path:
    """One planned run on an emulator with a mass on its tip."""
    mechanics = Mechanics(
        payload=payload,
        hand=HeldForm(stiffness=0.0, damping=0.0),
        home_error=list(OFFSETS),
        torque_gain=list(gain),
        **MADE_OF,
    )
    parameters = {"device": 1, "initial_tip_position": (0.019, 0.1)}
    order = Order(name="haply", lockstep=True, parameters=parameters, mechanics=mechanics)
    with Emulator(order) as emulator:
        file = folder / "haply.device.yaml"
        if not file.exists():
            save(file, {"driver": "haply", "preset": "haply", "home": list(emulator.home)})
        plan, run = folder / f"plan-{payload:g}.yaml", folder / f"run-{payload:g}"
        given = ["--url", emulator.url, "--seconds", seconds, "--payload", f"{payload} kg"]
        assert command("identify", "--plan", str(file), *given, "--out", str(plan))[0] == 0
        output = ["--enable-output", "--yes", "--no-figure", "--no-report"]
        assert command("run", str(plan), *output, "--out", str(run))[0] == 0
    return run


@pytest.mark.slow
def test_one_run_tells_an_emulated_haply_but_for_its_gain(tmp_path):
    run = excited(tmp_path, 0.0, "20", gain=(1.0, 1.0))
    found = json.loads(command("identify", str(run), "--json")[1])["estimates"]
    inertia = inertia_matrix(HAPLY, HOME) @ VALUES[:5]
    assert found["home_11"]["value"] == pytest.approx(inertia[0, 0], rel=INERTIA)
    assert found["home_22"]["value"] == pytest.approx(inertia[1, 1], rel=INERTIA)
    assert found["coulomb_1"]["value"] == pytest.approx(0.005, rel=COULOMB)
    assert found["coulomb_2"]["value"] == pytest.approx(0.005, rel=COULOMB)
    assert found["latency"]["value"] * 1024 == pytest.approx(1.0, abs=LATENCY_TICKS)
    for name in ("viscous_1", "viscous_2", "gain_1", "gain_2"):
        assert found[name]["value"] is None
    assert found["viscous_1"]["low"] < 1e-5 < found["viscous_1"]["high"]


@pytest.mark.exhaustive
def test_two_runs_tell_an_emulated_haply_and_the_preset_is_used(tmp_path):
    runs = [excited(tmp_path, 0.0, "40"), excited(tmp_path, PAYLOAD, "40")]
    preset, figure = tmp_path / "preset.yaml", tmp_path / "fit.png"
    names = [str(each) for each in runs]
    status, text = command(
        "identify", *names, "--json", "--out", str(preset), "--figure", str(figure)
    )
    said = json.loads(text)
    assert status == 0, said
    found = {name: each["value"] for name, each in said["estimates"].items()}
    inertia = inertia_matrix(HAPLY, HOME) @ VALUES[:5]
    assert found["home_11"] == pytest.approx(inertia[0, 0], rel=INERTIA)
    assert found["home_22"] == pytest.approx(inertia[1, 1], rel=INERTIA)
    assert found["coulomb_1"] == pytest.approx(0.005, rel=COULOMB)
    assert found["coulomb_2"] == pytest.approx(0.005, rel=COULOMB)
    assert found["latency"] * 1024 == pytest.approx(1.0, abs=LATENCY_TICKS)
    assert [found["offset_1"], found["offset_2"]] == pytest.approx(OFFSETS, abs=OFFSET)
    assert [found["gain_1"], found["gain_2"]] == pytest.approx(TRUE_GAIN, rel=GAIN)
    assert said["estimates"]["viscous_1"]["value"] is None
    assert figure.stat().st_size > 10_000
    _ablations(names, found, inertia)
    _is_used(tmp_path, preset)


def _ablations(names: list[str], found: dict[str, float], inertia: np.ndarray) -> None:
    """A wrong mass breaks gain and inertia; without one there is no gain, and friction is off."""
    light = json.loads(command("identify", *names, "--payload", f"{names[1]}=45 g", "--json")[1])
    wrong = {name: each["value"] for name, each in light["estimates"].items()}
    assert abs(wrong["gain_1"] / TRUE_GAIN[0] - 1) > GAIN
    assert abs(wrong["home_11"] / inertia[0, 0] - 1) > INERTIA
    alone = json.loads(command("identify", names[0], "--json")[1])["estimates"]
    assert alone["gain_1"]["value"] is None
    # Its torque has no scale: each joint's friction is off by its motor's gain.
    for joint, gain in zip((1, 2), TRUE_GAIN, strict=True):
        friction = alone[f"coulomb_{joint}"]["value"]
        assert friction == pytest.approx(0.005 / gain, rel=COULOMB)
        assert abs(friction / 0.005 - 1) > COULOMB


def _is_used(folder: Path, preset: Path) -> None:
    """A scenario that includes the preset runs, and otherwise than with the published device."""
    text = """
cohaptic: 1
title: A push
duration: 0.2 s
rates: {control: 1024 Hz}
components:
  push: {fmu: signal, rate: control, parameters: {mode: step, amplitude: 0.02}}
  finger:
    fmu: pantograph
    rate: control
    parameters: {%s, initial_tip_position: [0.019, 0.1]}
connections: ["push.value -> finger.motor_torque[1]"]
"""
    moved: list[float] = []
    for name, what in (("measured", f"include: {preset.name}"), ("published", "device: haply")):
        (folder / f"{name}.yaml").write_text(text % what)
        run = folder / f"used-{name}"
        arguments = ["run", str(folder / f"{name}.yaml"), "--no-figure", "--no-report"]
        assert command(*arguments, "--out", str(run))[0] == 0
        with open_run(run) as record:
            moved.append(float(record["finger.true_joint_angle[1]"].values[-1]))
    assert abs(moved[0] - moved[1]) > 1e-3


FORCE = {
    "impedance": "custom",
    "stiffness": [0.0, 0.0],
    "damping": [0.0, 0.0],
    "force_mode": ["sine", "sine"],
    "force_amplitude": [0.2, 0.2],
    "force_frequency": [9.0, 14.0],
}
"""A hand that pushes the handle whatever it does (N, rad/s).

The motors hold the handle with some 15 N/m, so that it pushes gently: 1 N drives it away.
"""


@pytest.mark.slow
def test_a_real_sensors_record_tells_the_gain(tmp_path):
    """The board of the sensor is asked over its own line; what it measures pushes the device."""
    mechanics = Mechanics(
        hand=HeldForm(stiffness=0.0, damping=0.0), torque_gain=list(TRUE_GAIN), **MADE_OF
    )
    order = Order(
        name="haply",
        lockstep=True,
        parameters={"device": 1, "initial_tip_position": (0.019, 0.1)},
        mechanics=mechanics,
        operator=FORCE,
    )
    # The sensor's board has a body of its own, which is pushed alike and hardly moves.
    heavy = {"device": 0, "initial_tip_position": (0.0425, 0.2), "finger_mass": 5.0}
    other = Order(name="force_sensor", lockstep=True, parameters=heavy, operator=FORCE)
    with Emulator(order) as emulator, Emulator(other) as sensor:
        file, plan, run = (tmp_path / each for each in ("haply.device.yaml", "plan.yaml", "run"))
        save(file, {"driver": "haply", "preset": "haply", "home": list(emulator.home)})
        given = ["--url", emulator.url, "--seconds", "12", "--out", str(plan)]
        assert command("identify", "--plan", str(file), *given)[0] == 0
        measuring = tmp_path / "sensor.device.yaml"
        asked = {"driver": "force_sensor", "preset": "six_axis", "settings": {"tare": False}}
        measuring.write_text(json.dumps(asked))
        beside = tmp_path / "beside.yaml"
        device = json.dumps({"url": sensor.url, "file": str(measuring)})
        beside.write_text(f"components: {{force: {{rate: control, device: {device}}}}}\n")
        output = ["--enable-output", "--yes", "--no-figure", "--no-report"]
        done = command("run", str(plan), "--with", str(beside), *output, "--out", str(run))
        assert done[0] == 0
    found = cohaptic.identify(run, component="finger", force="force.force")
    assert [found["gain_1"].value, found["gain_2"].value] == pytest.approx(TRUE_GAIN, rel=GAIN)
    with pytest.raises(InputError, match=r"geometry|payloads"):
        cohaptic.identify(run, component="finger")
