"""What the first release read, this one reads: its own scenarios, and the device files of then."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.reading import FORMS
from cosim.scenario import load
from hil.setup.device_file import load as load_device

SCENARIOS = sorted((Path(__file__).parents[2] / "support/scenario/release_0_1_0").glob("*.yaml"))
DEVICES = {
    "calibrated": """
cohaptic_device: 1
driver: haply
preset: haply
date: '2026-03-01'
home: [2.427, 0.714]
joints:
- {direction: 1, counts_per_turn: 4880}
- {direction: -1, counts_per_turn: 4880}
serial: '5573'
estop: confirmed
""",
    "by hand": """
driver: quanser
serial: 5573
date: 2026-03-01
estop: none
geometry: {proximal: 0.1, distal: 0.165, base: 0.085}
joints:
  - {direction: 1, offset: 0.1, counts_per_turn: 20000.0, drive: {bias: 0.5, gear: 1}}
  - {}
limits: {torque: 0.17, ramp_time: 2}
loosened: {torque: "the motors' rated stall torque"}
workspace: {left: -0.05, right: 0.15, bottom: 0.1, top: 0.25}
settings: {watchdog: {timeout: 0.02}, digital_outputs: 16}
watchdog_proof: {date: 2026-03-01, timeout: 0.02, fired_after: 0.05, serial: 5573}
""",
    "CANopen": """
driver: canopen
settings:
  nodes: [1, 2]
  encoders: [{node: 1, object: 0x6004}, {node: 2}]
  heartbeat: 5
  watchdog: 20
  timeout: 5
  absolute: true
  preset: false
""",
    "ODrive": """
driver: odrive
settings: {current_limit: 8, watchdog: {timeout: 0.02, timeout_endpoint: 5, enable_endpoint: 6}}
""",
    "emulated": "driver: mock\npreset: quanser\nhome: [2.28, 0.85]\n",
}


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_a_scenario_of_then_loads(file) -> None:
    scenario = load(file, forms=FORMS)
    assert scenario.components
    assert scenario.expect == load(file).expect


@pytest.mark.parametrize("name", DEVICES)
def test_a_device_file_of_then_loads(name, tmp_path) -> None:
    path = tmp_path / "device.yaml"
    path.write_text(DEVICES[name])
    assert load_device(path).driver
