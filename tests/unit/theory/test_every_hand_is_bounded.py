"""μ meets the published value, the uncertain loop is the loop, and no unstable hand is missed."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import find_root
from cosim.theory.robust.hands import robustness, uncertain_hands
from cosim.theory.robust.structured import Uncertain, upper_bound
from cosim.theory.stability.spectral_radius import stability


def test_the_example_of_slicot():
    rows = np.array(
        [
            [-1 + 6j, 2 - 3j, 3 + 8j, 3 + 8j, -5 - 9j, -6 + 2j],
            [4 + 2j, -2 + 5j, -6 - 7j, -4 + 11j, 8 - 7j, 12 - 1j],
            [5 - 4j, -4 - 8j, 1 - 3j, -6 + 14j, 2 - 5j, 4 + 16j],
        ]
    )
    structure = (
        *(Uncertain("real"), Uncertain("real"), Uncertain("full", 2)),
        *(Uncertain("complex"), Uncertain("complex")),
    )
    # AB13MD of SLICOT, whose example prints 41.74753408.
    assert upper_bound(np.vstack([rows, rows]), structure, 1e-4) == pytest.approx(41.7475, rel=2e-4)


def test_one_full_block_is_the_largest_singular_value():
    matrix = np.array([[1.0 + 1j, 2.0], [0.5, -1j]])
    found = upper_bound(matrix, (Uncertain("full", 2),), 1e-6)
    assert found == pytest.approx(np.linalg.norm(matrix, 2), rel=1e-5)


def test_a_real_parameter_does_not_turn():
    # δ real cannot make 1 − jδ zero, δ complex can.
    assert upper_bound(np.array([[1j]]), (Uncertain("real"),)) < 1e-3
    assert upper_bound(np.array([[1j]]), (Uncertain("complex"),)) == pytest.approx(1.0, rel=1e-2)


def loop(architecture: str, **values: float):
    return Parameters(architecture, values, TABLE_6_1[architecture]).model()


@pytest.mark.parametrize("architecture", ["centralized", "distributed"])
def test_the_uncertain_loop_at_a_mass_is_the_loop_with_that_mass(architecture):
    timing = Timing(delay=PathDelay(1, 0))
    uncertain = uncertain_hands(loop(architecture), timing, {"mass": (0.05, 0.2)})
    for deltas in ((0.0, 0.0), (1.0, -1.0), (-0.4, 0.7)):
        masses = {
            f"m_h{one.hand + 1}": one.at(delta)
            for one, delta in zip(uncertain.parameters, deltas, strict=True)
        }
        expected = stability(loop(architecture, **masses), timing).spectral_radius
        assert uncertain.radius_at(np.array(deltas)) == pytest.approx(expected, rel=1e-9)


def test_a_hand_that_holds_on_is_a_spring_sampled_at_the_control_rate():
    """A hand alone in a loop without couplers: x⁺ = x + T v + T²/2m f, f = −k x − b v."""
    model = loop("distributed", **dict.fromkeys(("k_11", "k_12", "b_11", "b_12"), 0.0))
    uncertain = uncertain_hands(
        model, Timing(), {"stiffness": (100.0, 800.0), "damping": (3.0, 15.0)}
    )
    found = np.linalg.eigvals(uncertain.map_at(np.ones(4)))
    period, mass = 1 / 1024, 0.1
    tick = np.array([[1.0, period], [0.0, 1.0]]) - np.outer(
        [period**2 / (2 * mass), period / mass], [800.0, 15.0]
    )
    for value in np.linalg.eigvals(np.linalg.matrix_power(tick, 8)):
        assert np.min(np.abs(found - value)) < 1e-9


def test_an_unstable_corner_is_never_called_stable():
    """The further the remote coupler is from stability, the smaller the hands that are proved."""
    timing = Timing(delay=PathDelay(1, 0))
    frequencies = np.geomspace(20.0, 400.0, 8)
    bounds: list[float] = []
    for stiffness in (85.0, 400.0):
        model = loop("centralized", k_2=stiffness)
        uncertain = uncertain_hands(model, timing, {"mass": (0.03, 0.3)})
        found = robustness(uncertain, frequencies, 0.05)
        bounds.append(found.bound)
        assert found.worst >= found.nominal
        if found.worst >= 1.0:
            assert found.verdict == "unstable"
        elif found.bound < 1.0:
            grid = [uncertain.radius_at(np.array([a, b])) for a in (-1, 0, 1) for b in (-1, 0, 1)]
            assert max(grid) < 1.0
    assert bounds[1] > bounds[0]


def test_where_a_mass_makes_it_unstable_the_bound_is_one_at_least():
    """δ with an eigenvalue on the circle bounds μ at its frequency from below by 1/|δ|."""
    timing = Timing(delay=PathDelay(1, 0))
    model = loop("centralized", k_2=100.0)
    uncertain = uncertain_hands(model, timing, {"mass": (0.02, 2.0)})
    light = np.ones(2)
    step = find_root(lambda x: uncertain.radius_at(x * light) - 1.0, 0.0, 1.0)
    values = np.linalg.eigvals(uncertain.map_at(step * light))
    # Of those on the circle the one that turns: translation is there anyway.
    turning = values[np.abs(values - 1.0) > 1e-3]
    at = turning[np.argmin(np.abs(np.abs(turning) - 1.0))]
    structure = (Uncertain("real", uncertain.samples, 1),) * 2
    response = uncertain.response(abs(np.angle(at)) / uncertain.period)
    assert upper_bound(response, structure, 1e-2) >= 0.999 / step > 1.0


def test_a_hand_with_damping_of_its_own_is_refused_by_name():
    model = loop("centralized", b_h=1.0)
    with pytest.raises(InputError, match="b_h"):
        uncertain_hands(model, Timing(), {"mass": (0.05, 0.2)})
