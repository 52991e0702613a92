"""docs/thesis.md is what the theory computes now, and its figures and readings hold."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cosim.theory.chapters.page.whole import thesis_page
from cosim.theory.models.direct import direct_model
from cosim.theory.models.lifting import LiftedSignal, lift
from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import spectral_radius

PAGE = Path(__file__).parents[3] / "docs" / "thesis.md"


def test_the_page_is_what_is_computed_now() -> None:
    assert PAGE.read_text(encoding="utf-8") == thesis_page()


def test_every_figure_of_the_page_exists() -> None:
    text = PAGE.read_text(encoding="utf-8")
    linked = [part.split(")")[0] for part in text.split("](")[1:]]
    assert len(linked) == 7
    for name in linked:
        assert (PAGE.parent / name).stat().st_size > 10_000


def test_the_third_line_of_4_26_taken_literally_is_unstable() -> None:
    """K_2 (X_h1 + X_o) on hand 2, x_2 measured the other way round, Table 6.1, n = 0."""
    A = np.kron(np.eye(3), [[0.0, 1.0], [0.0, 0.0]])

    def gains(k: float, b: float, *signs: tuple[int, float]) -> np.ndarray:
        row = np.zeros(6)
        for body, sign in signs:
            row[2 * body : 2 * body + 2] = sign * k, sign * b
        return row

    def on(*forces: tuple[int, float]) -> np.ndarray:
        column = np.zeros(6)
        for body, force in forces:
            column[2 * body + 1] = force
        return column

    hand, body, other = (0, 10.0), (1, 2.5), (2, 10.0)
    shared = [
        LiftedSignal(1, gains(1000, 15, (0, 1), (1, -1)), {}, on((0, -hand[1]), (1, body[1]))),
        LiftedSignal(8, gains(85, 3, (2, 1))),
        LiftedSignal(1, gains(85, 3, (1, 1)), {1: 1.0}, on((1, -body[1]))),
    ]

    def radius(source: int) -> float:
        down = LiftedSignal(8, gains(85, 3, (source, 1), (1, 1)), {}, on((2, -other[1])))
        return spectral_radius(lift(A, [*shared, down], 1 / 1024, ticks=8).map)

    assert f"{radius(0):.3f}" == "1.247"
    model = Parameters("centralized", {}, TABLE_6_1["centralized"]).model()
    right = direct_model(model, Timing(ratio=Fraction(8))).lifted.map
    assert radius(2) == pytest.approx(spectral_radius(right), rel=1e-9)
