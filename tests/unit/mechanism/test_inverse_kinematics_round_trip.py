"""The pantograph starts where it is told to, or says why it cannot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance, ModelError
from tests.support.physics.planar_oracle import preset_bar


@settings(deadline=None)
@given(
    x=st.floats(-0.02, 0.10),
    y=st.floats(0.14, 0.23),
    base=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-7, 7)),
)
def test_tip_starts_where_it_is_told_to(x: float, y: float, base: tuple[float, ...]) -> None:
    bar = preset_bar(0, base[:2], base[2])
    wanted = np.array(bar.origin) + bar.rotation @ [x, y]
    device = Instance(
        "pantograph",
        base_x=base[0],
        base_y=base[1],
        base_angle=base[2],
        initial_tip_position=wanted,
        encoder_counts=0,
    )
    device.initialise()
    np.testing.assert_allclose(device["tip_position"], wanted, rtol=0, atol=1e-12)
    np.testing.assert_allclose(bar.world(device["joint_angle"]), wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("tip", "says"),
    [
        ((0.0425, 0.3), "out of reach"),
        ((0.0425, -0.2), "beyond its mechanical stops"),
        ((0.0425, 0.055), "beyond its mechanical stops"),
        ((float("nan"), 0.2), "out of reach"),
    ],
)
def test_a_tip_that_cannot_be_reached_is_refused(tip: tuple[float, float], says: str) -> None:
    device = Instance("pantograph", initial_tip_position=tip)
    with pytest.raises(ModelError, match=says):
        device.initialise()


def test_a_custom_device_must_say_everything() -> None:
    device = Instance("pantograph", device=2)
    with pytest.raises(ModelError, match="proximal_length must be given"):
        device.initialise()


def test_a_given_parameter_replaces_the_preset_only_there() -> None:
    haply = {"device": 1, "initial_tip_position": (0.019, 0.11)}
    plain, other = Instance("pantograph", **haply), Instance("pantograph", **haply)
    plain.initialise()
    other.initialise(encoder_counts=0)
    assert plain["encoder_count[1]"] != 0
    assert other["encoder_count[1]"] == 0
    np.testing.assert_array_equal(plain["true_joint_angle"], other["true_joint_angle"])


@pytest.mark.parametrize(
    ("parameter", "value", "says"),
    [
        ("substeps", 0, "substeps"),
        ("computation_delay_ticks", 9, "computation_delay_ticks"),
        ("dac_bits", 1, "dac_bits"),
        ("proximal_length", 0.0, "proximal_length"),
        ("torque_constant", 0.0, "torque_constant"),
        ("proximal_inertia", 0.0, "proximal_inertia"),
        ("joint_minimum", 4.0, "joint_minimum"),
    ],
)
def test_nonsense_is_refused_by_name(parameter: str, value: float, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        Instance("pantograph").initialise(**{parameter: value})
