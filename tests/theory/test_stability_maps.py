"""Whole stability maps by the Schur–Cohn test equal eigenvalues, cell by cell."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.theory.chapter_5 import DELAYS, FIGURES, StabilityFigure
from cosim.theory.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.schur_cohn import all_roots_inside, divide_by_z_minus_one, multiply
from cosim.theory.stability import stability
from cosim.theory.stability_map import Axis, stability_maps
from cosim.theory.timing import Delay, Timing


@settings(deadline=None)
@given(
    st.lists(st.complex_numbers(max_magnitude=1.5), min_size=1, max_size=5),
    st.lists(st.floats(-1.5, 1.5), max_size=3),
)
def test_schur_cohn_knows_the_roots(pairs: list[complex], reals: list[float]) -> None:
    roots = np.array([*pairs, *np.conj(pairs), *reals])
    largest = float(np.max(np.abs(roots)))
    if abs(largest - 1) < 1e-2:
        return
    assert bool(all_roots_inside(np.real(np.poly(roots)))) == (largest < 1)


def test_polynomial_arithmetic() -> None:
    one, other = np.array([1.0, -3.0, 2.0]), np.array([2.0, 5.0])
    assert np.array_equal(multiply(one, other), np.polymul(one, other))
    assert np.array_equal(divide_by_z_minus_one(one), [1.0, -2.0])


def by_eigenvalues(
    parameters: Parameters, timing: Timing, x: Axis, y: Axis, delays: tuple[int, ...]
) -> np.ndarray:
    cells = np.zeros((len(delays), y.values.size, x.values.size), dtype=bool)
    for row, vertical in enumerate(y.values):
        for column, horizontal in enumerate(x.values):
            model = parameters.replaced({x.name: horizontal, y.name: vertical}).model()
            for number, n in enumerate(delays):
                timed = Timing(
                    timing.control_period,
                    timing.ratio,
                    Delay.round_trip(n),
                    timing.computation_delay,
                )
                cells[number, row, column] = stability(model, timed).stable
    return cells


@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_no_cell_of_a_figure_differs(figure: StabilityFigure) -> None:
    x, y = figure.axes(points=11)
    fast = stability_maps(figure.parameters(), Timing(), x, y, DELAYS)
    assert np.array_equal(fast, by_eigenvalues(figure.parameters(), Timing(), x, y, DELAYS))


@pytest.mark.slow
@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_no_cell_of_a_full_figure_differs(figure: StabilityFigure) -> None:
    x, y = figure.axes()
    fast = stability_maps(figure.parameters(), Timing(), x, y, DELAYS)
    assert np.array_equal(fast, by_eigenvalues(figure.parameters(), Timing(), x, y, DELAYS))


@pytest.mark.parametrize(
    ("architecture", "given", "x", "y", "timing"),
    [
        ("single", {}, ("k", 40000.0), ("b", 40.0), Timing(ratio=Fraction(1))),
        (
            "single",
            {"b_h": 0.5},
            ("k", 40000.0),
            ("b", 40.0),
            Timing(Fraction(1, 1024), Fraction(1), Delay(), 1),
        ),
        (
            "distributed",
            {"m_h2": 0.3, "k_21": 90.0},
            ("k_11", 9000.0),
            ("k_12", 60000.0),
            Timing(ratio=Fraction(3)),
        ),
        ("distributed", {"b_c": -1.0, "b_h": 0.2}, ("k_o", 9000.0), ("b_o", 40.0), Timing()),
        (
            "distributed",
            {},
            ("k_11", 9000.0),
            ("k_12", 3000.0),
            Timing(Fraction(1, 1024), Fraction(8), Delay(), 2),
        ),
        ("centralized", {"k_w": 3000.0, "b_w": 5.0}, ("k_1", 9000.0), ("k_2", 900.0), Timing()),
    ],
)
def test_other_planes_agree_too(
    architecture: Architecture,
    given: dict[str, float],
    x: tuple[str, float],
    y: tuple[str, float],
    timing: Timing,
) -> None:
    parameters = Parameters(architecture, given, CHAPTER_5[architecture])
    axes = Axis.even(*x, 8), Axis.even(*y, 8)
    fast = stability_maps(parameters, timing, *axes, (0, 1))
    slow = by_eigenvalues(parameters, timing, *axes, (0, 1))
    assert np.array_equal(fast, slow)
    assert fast.any()
    assert not fast.all()


def test_three_users_are_decided_by_eigenvalues() -> None:
    parameters = Parameters("distributed", {}, CHAPTER_5["distributed"], users=3)
    axes = Axis.even("k_11", 20000.0, 3), Axis.even("k_12", 3000.0, 3)
    cells = stability_maps(parameters, Timing(), *axes, (1,))
    assert np.array_equal(cells, by_eigenvalues(parameters, Timing(), *axes, (1,)))
