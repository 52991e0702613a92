"""The radii that a page shows are those of ``cohaptic theory radius``."""

from __future__ import annotations

from itertools import product

import pytest

from cosim.analysis.loop import read_loop
from cosim.cli.support.play_theory import radii
from cosim.live.knobs.found import knobs_of
from cosim.reading import load
from cosim.theory.models.parameters import Parameters
from cosim.theory.stability.spectral_radius import stability


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("name", ["two_users_box", "two_users_box_centralized"])
def test_a_point_of_the_grid_is_the_scenario_with_those_values(name, delay):
    scenario = load(name)
    found = radii(scenario, knobs_of(scenario))
    keys, axes = zip(*found["axes"], strict=True)
    points = dict(zip(product(*axes), found["radii"], strict=True))
    samples, stiffness, compensation = delay, axes[1][-2], 0.0
    copies = "a", "b"
    sets = [f"channels.lan.round_trip_delay={samples}"]
    if name == "two_users_box":
        sets += [f"components.vr_{c}.parameters.{keys[1]}={stiffness}" for c in copies]
    else:
        sets.append(f"components.server.parameters.{keys[1]}={stiffness}")
    loop = read_loop(load(name, (), sets))
    model = Parameters(loop.architecture, loop.values, {}, users=loop.users).model()
    expected = stability(model, loop.timing).spectral_radius
    assert points[samples, stiffness, compensation] == pytest.approx(expected, rel=1e-5)
