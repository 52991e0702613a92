"""The theory takes a parameter in the unit that it is written in, as the run does."""

from __future__ import annotations

import pytest

from cosim.analysis.longest_delay import longest_delay
from cosim.analysis.loop import read_loop
from cosim.analysis.parameter import parameter
from cosim.base.errors import InputError
from cosim.reading import load
from cosim.sweep.theory import spectral_radius

WRITTEN = [
    ("single_axis_distributed", "coupler_12.parameters.stiffness", "900", "0.9 kN/m"),
    ("single_axis_centralized", "object.parameters.mass", "0.3", "300 g"),
    ("two_users_box", "vr_a.parameters.remote_normal_stiffness", "900", "0.9 kN/m"),
    ("two_users_box_centralized", "server.parameters.hand_mass", "0.2", "200 g"),
]


@pytest.mark.parametrize(("scenario", "place", "plain", "unit"), WRITTEN)
def test_a_unit_changes_no_number(scenario: str, place: str, plain: str, unit: str) -> None:
    loops = [
        read_loop(load(scenario, sets=[f"components.{place}={value}"] if value else []))
        for value in (plain, unit, "")
    ]
    assert loops[0] == loops[1] != loops[2]


def test_a_radius_and_a_delay_follow_it() -> None:
    found = []
    for value in ("900", "900 N/m"):
        sets = [f"components.coupler_{name}.parameters.stiffness={value}" for name in ("12", "21")]
        scenario = load("single_axis_distributed", sets=sets)
        found.append((spectral_radius(scenario), longest_delay(scenario)))
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("stiffness", "3 kg", r"coupler_12\.stiffness: "),
        ("stiffness", "much", r"coupler_12\.stiffness: "),
        ("stifness", "1", "Did you mean stiffness"),
    ],
)
def test_what_is_no_such_number_is_a_sentence(name: str, value: str, sentence: str) -> None:
    scenario = load(
        "single_axis_distributed", sets=[f"components.coupler_12.parameters.{name}={value}"]
    )
    with pytest.raises(InputError, match=sentence):
        parameter(scenario.components["coupler_12"], name)
