"""What a scenario puts on the tip is known: a planned mass, or a simulated device's hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from cohaptic.described import described
from cosim.identification.records import payload_of
from cosim.reading import load

SIMULATED = """
cohaptic: 1
title: A handle
duration: 1 s
rates: {control: 1024 Hz}
components:
  finger: {fmu: pantograph, rate: control, parameters: {device: haply%s}}
"""
PLANNED = """
cohaptic: 1
title: A handle
duration: 1 s
rates: {control: 1024 Hz}
components:
  finger: {device: {url: "mock://"}}
  excitation:
    python: "cosim.identification.excitation.controller:Excitation"
    rate: control
    parameters: {payload: 0.05}
connections: ["excitation.motor_torque -> finger.motor_torque"]
"""


def payload(folder: Path, text: str) -> float | None:
    file = folder / "handle.yaml"
    file.write_text(text)
    return payload_of(load(str(file)), "finger")


@pytest.mark.parametrize(
    ("given", "mass"), [("", 0.06), (", finger_mass: 80 g", 0.08), (", finger_mass: 0", 0.0)]
)
def test_a_simulated_device_says_which_hand_it_carries(tmp_path, given, mass) -> None:
    assert payload(tmp_path, SIMULATED % given) == pytest.approx(mass)


def test_the_hand_counts_though_an_excitation_was_planned_for_a_bare_device(tmp_path) -> None:
    device = '  finger: {device: {url: "mock://"}}\n'
    simulated = "  finger: {fmu: pantograph, rate: control}\n"
    assert payload(tmp_path, PLANNED.replace(device, simulated)) == pytest.approx(0.06)


def test_of_a_device_the_plan_says_it(tmp_path) -> None:
    assert payload(tmp_path, PLANNED) == pytest.approx(0.05)
    bare = PLANNED.replace('connections: ["excitation.motor_torque -> finger.motor_torque"]', "")
    assert payload(tmp_path, bare) is None


@pytest.mark.parametrize("mass", ["0.05", "50 g"])
def test_a_mass_may_be_written_with_its_unit(tmp_path, mass) -> None:
    written = PLANNED.replace("payload: 0.05", f"payload: {mass}")
    assert payload(tmp_path, written) == pytest.approx(0.05)


def test_so_may_lengths_and_the_torque_limit(tmp_path) -> None:
    file = tmp_path / "handle.yaml"
    given = ", proximal_length: 70 mm, distal_length: 9 cm, torque_limit: 100 mN.m"
    file.write_text(SIMULATED % given)
    found = described(load(str(file)), "finger", None)
    assert (found.bar.proximal, found.bar.distal, found.limit) == pytest.approx((0.07, 0.09, 0.1))
