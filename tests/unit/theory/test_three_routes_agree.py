"""Subsystem resampling, direct lifting and the tick-by-tick simulation have the same spectrum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg
import scipy.optimize
from hypothesis import given, settings

from cosim.theory.models.assembly import assemble
from cosim.theory.models.direct import direct_model
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.monodromy import monodromy
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import eigenvalues
from cosim.theory.stability.quotient import without_translation
from tests.support.theory.strategies import RATIONAL_RATIOS, WHOLE_RATIOS, models, timings


def disagreement(one: np.ndarray, other: np.ndarray) -> float:
    """How far the nonzero eigenvalues of two matrices of different sizes are apart, over 1.

    Eigenvalues are paired one to one, the smaller matrix filled up with zeros. Allowed is 1e-10
    times the eigenvalue's own condition number: two eigenvalues that all but coincide move by more
    than that in any arithmetic of 16 digits.
    """
    small, large = sorted((one, other), key=len)
    balanced = scipy.linalg.matrix_balance(large)[0]
    values, left, right = scipy.linalg.eig(balanced, left=True, right=True)
    condition = 1.0 / np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), 1e-12)
    partners = np.zeros(len(large), dtype=complex)
    partners[: len(small)] = eigenvalues(small)
    distance = np.abs(values[:, None] - partners[None, :])
    rows, columns = scipy.optimize.linear_sum_assignment(distance)
    scale = max(1.0, float(np.max(np.abs(values))))
    # Zeros of delay chains are defective and scatter around 0; only nonzero ones are compared.
    counted = np.abs(values[rows]) > 1e-2 * scale
    error = distance[rows, columns] / (1e-10 * scale * condition[rows])
    return float(np.max(error[counted]))


def quotients(model: Model, timing: Timing) -> list[np.ndarray]:
    """The loop's map by every route that takes its ratio, without a neutral translation."""
    direct = direct_model(model, timing)
    found = [monodromy(model, timing), (direct.lifted.map, direct.translation)]
    if timing.ratio.denominator == 1:
        frame = assemble(model, timing).frame()
        found.append((frame.map, frame.translation))
    return [one[0] if model.grounded else without_translation(*one) for one in found]


@settings(deadline=None, max_examples=40)
@given(models(), timings(WHOLE_RATIOS))
def test_the_three_routes_agree_at_whole_ratios(model: Model, timing: Timing) -> None:
    simulated, lifted, resampled = quotients(model, timing)
    assert disagreement(resampled, simulated) < 1
    assert disagreement(resampled, lifted) < 1


@settings(deadline=None, max_examples=40)
@given(models(), timings(RATIONAL_RATIOS))
def test_lifting_and_simulation_agree_at_any_rational_ratio(model: Model, timing: Timing) -> None:
    simulated, lifted = quotients(model, timing)[:2]
    assert disagreement(lifted, simulated) < 1


@settings(deadline=None, max_examples=30)
@given(models(), timings(WHOLE_RATIOS))
def test_translation_is_an_exact_fixed_vector_of_free_hands(model: Model, timing: Timing) -> None:
    frame = assemble(replace(model, hand_stiffness=0.0), timing).frame()
    assert np.allclose(frame.map @ frame.translation, frame.translation, rtol=1e-12, atol=1e-9)


def test_the_comparison_notices_a_wrong_model() -> None:
    """The comparison itself must fail for a loop with one stiffness off by a part in 10⁶."""
    rng = np.random.default_rng(3)
    one = rng.normal(size=(6, 6)) / 3
    other = one.copy()
    other[2, 3] *= 1 + 1e-6
    assert disagreement(one, other) > 1
