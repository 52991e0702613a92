"""Passivity by Colgate and Schenkel's condition; margins that a perturbed loop confirms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.margins import margins, scaled
from cosim.theory.stability.passivity import damping_for_passivity, passive_stiffness
from cosim.theory.stability.spectral_radius import stability

T = 1 / 1024


@given(st.floats(0, 5000), st.floats(0, 20))
def test_undelayed_coupler_needs_the_textbook_damping(stiffness: float, damping: float) -> None:
    """b > K T/2 + |B| (Colgate and Schenkel 1997)."""
    needed = damping_for_passivity(stiffness, damping, T)
    assert needed == pytest.approx(stiffness * T / 2 + damping, rel=1e-6, abs=1e-9)


@given(st.floats(1, 5000), st.integers(0, 4))
def test_a_delayed_spring_needs_more(stiffness: float, delay: int) -> None:
    """K (T/2 + d T), the low-frequency limit."""
    needed = damping_for_passivity(stiffness, 0.0, T, delay)
    assert needed == pytest.approx(stiffness * T * (0.5 + delay), rel=1e-4)


@given(st.floats(0.1, 10), st.floats(0, 0.9), st.integers(0, 3))
def test_z_width_is_the_edge_of_passivity(device: float, share: float, delay: int) -> None:
    damping = device * share / (1 + 2 * delay)
    limit = passive_stiffness(device, damping, T, delay)
    if limit is None:
        assert damping_for_passivity(0.0, damping, T, delay) > device
        return
    assert damping_for_passivity(limit, damping, T, delay) == pytest.approx(device, rel=1e-9)


def test_too_much_coupler_damping_leaves_no_z_width() -> None:
    assert passive_stiffness(1.0, 1.5, T) is None
    with pytest.raises(InputError, match="cannot be negative"):
        passive_stiffness(-1.0, 0.0, T)


@pytest.mark.parametrize("architecture", ["single", "centralized", "distributed"])
def test_margins_are_where_stability_ends(architecture: Architecture) -> None:
    model = Parameters(architecture, {}, CHAPTER_5[architecture]).model()
    timing = Timing(ratio=1) if architecture == "single" else Timing(delay=PathDelay.round_trip(1))
    found = margins(model, timing)
    for kind, (low, high) in (("stiffness", found.stiffness), ("damping", found.damping)):
        assert low <= 1 <= high
        if high < 100:
            inside = stability(scaled(model, **{kind: high * 0.999}), timing)
            outside = stability(scaled(model, **{kind: high * 1.001}), timing)
            assert inside.stable
            assert not outside.stable
    if architecture == "single":
        assert found.network is None
        assert found.delay is None
        assert found.stiffness[1] == pytest.approx(20480 / 1000, rel=1e-6)
    else:
        assert found.delay is not None
        limit = stability(model, Timing(delay=PathDelay.round_trip(1 + found.delay)))
        beyond = stability(model, Timing(delay=PathDelay.round_trip(2 + found.delay)))
        assert limit.stable
        assert not beyond.stable


def test_an_unstable_design_point_has_no_margins() -> None:
    model = Parameters("centralized", {"k_2": 2000.0}, CHAPTER_5["centralized"]).model()
    with pytest.raises(InputError, match="lower the network couplers' stiffness"):
        margins(model, Timing(delay=PathDelay.round_trip(2)))


def test_network_margin_leaves_the_local_coupler_alone() -> None:
    model = Parameters("distributed", {}, CHAPTER_5["distributed"]).model()
    half = scaled(model, 0.5, 0.5, network_only=True)
    assert np.array_equal(half.local_stiffness, model.local_stiffness)
    assert np.array_equal(half.object_stiffness, model.object_stiffness / 2)
