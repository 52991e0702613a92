"""A small valid scenario that tests change, and a way to load text as one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.scenario import Scenario, load

SMALL = """\
cohaptic: 1
title: Two devices and a network
duration: 2 s
rates: {control: 1024, network: 128}
components:
  left: {fmu: pantograph, station: a, rate: control, parameters: {base_x: 0.1}}
  right: {fmu: pantograph, station: b, rate: control}
  third: {fmu: pantograph, station: b, rate: control}
channels:
  lan: {between: [a, b], rate: network, round_trip_delay: 1}
connections:
  - left.joint_angle -> right.motor_torque via lan
  - right.joint_angle -> third.motor_torque
record: [left.*]
expect: {left.energy: {max_below: 1}}
"""


@pytest.fixture
def small() -> str:
    return SMALL


@pytest.fixture
def scenario_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Scenario]:
    """Loads text as ``s.yaml`` of an empty working folder, with overlay texts and overrides."""
    monkeypatch.chdir(tmp_path)

    def make(text: str, *overlays: str, sets: tuple[str, ...] = ()) -> Scenario:
        (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
        names: list[str] = []
        for number, overlay in enumerate(overlays, start=1):
            names.append(f"o{number}.yaml")
            (tmp_path / names[-1]).write_text(overlay, encoding="utf-8")
        return load("s.yaml", names, sets)

    return make
