"""A scenario of real FMUs runs through the kernel, and its record is what the physics says."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.support.master.master_support import run, scenario_of

HAND = """
    duration: 0.5
    rates: {control: 1024}
    components:
      hand:
        fmu: hand
        rate: control
        parameters: {mass: 0.1, initial_position: 0.01, initial_velocity: -0.2}
        start: {force: 0.3}
"""


def test_a_hand_under_a_constant_force_is_a_parabola(tmp_path: Path) -> None:
    sink, simulation = run(scenario_of(tmp_path, HAND))
    t = np.arange(512) / 1024
    acceleration = 0.3 / 0.1
    assert simulation.outcome.ticks == 512
    np.testing.assert_allclose(
        sink.signal("hand.position"), 0.01 - 0.2 * t + acceleration * t**2 / 2, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        sink.signal("hand.velocity"), -0.2 + acceleration * t, rtol=0, atol=1e-12
    )
