"""Translation and, where momentum is conserved, common velocity are left out; nothing else is."""

from __future__ import annotations

import numpy as np

from cosim.theory.models.assembly import assemble
from cosim.theory.models.parameters import CHAPTER_5, TABLE_6_1, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import uniform_compensation


def parameters(architecture: Architecture = "distributed", **given: float) -> Parameters:
    return Parameters(architecture, given, CHAPTER_5[architecture])


def test_a_single_user_with_a_free_object_is_marginal() -> None:
    found = stability(parameters("single").model(), Timing(ratio=1))
    assert found.marginal
    assert found.stable
    assert found.spectrum.values.size == 2


def test_a_damped_hand_is_not_marginal() -> None:
    found = stability(parameters("single", b_h=0.5).model(), Timing(ratio=1))
    assert not found.marginal
    assert found.stable


def test_cooperative_loops_are_not_marginal() -> None:
    for architecture in ("centralized", "distributed"):
        assert not stability(parameters(architecture).model(), Timing()).marginal


def test_an_exactly_compensated_loop_is_marginal_and_an_overcompensated_one_unstable() -> None:
    model = Parameters("distributed", {}, TABLE_6_1["distributed"]).model((True, False))
    timing = Timing(delay=PathDelay.round_trip(1))
    null = null_compensation(model, timing, 0).value
    exact = stability(uniform_compensation(model, null), timing)
    assert exact.marginal
    assert exact.stable
    over = stability(uniform_compensation(model, null * 1.001), timing)
    assert not over.marginal
    assert not over.stable
    under = stability(uniform_compensation(model, null * 0.999), timing)
    assert not under.marginal
    assert under.stable


def test_copies_that_nothing_ties_together_drift_and_are_not_called_stable() -> None:
    found = stability(parameters(k_12=0.0, k_o=0.0).model(), Timing())
    assert found.spectral_radius >= 1.0 - 1e-12
    assert not found.stable


def test_a_wall_leaves_nothing_neutral() -> None:
    model = parameters(k_w=30000.0, b_w=20.0).model()
    frame = assemble(model, Timing()).frame()
    found = stability(model, Timing())
    assert found.spectrum.values.size == frame.map.shape[0]
    assert np.abs(found.spectrum.values[0]) < 1.0
