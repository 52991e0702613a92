"""Stability boundaries: one point of each figure, re-entrant regions, independent checks."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.theory.models.monodromy import monodromy
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.quotient import decisive_spectrum
from cosim.theory.stability.spectral_radius import stability, stable_intervals


def timing(n: int) -> Timing:
    return Timing(delay=PathDelay.round_trip(n))


def intervals(
    architecture: Architecture, given: dict[str, float], vary: str, n: int, high: float = 50000.0
) -> list[tuple[float, float]]:
    base = Parameters(architecture, given, CHAPTER_5[architecture])

    def radius(value: float) -> float:
        return stability(base.replaced({vary: value}).model(), timing(n)).spectral_radius

    return stable_intervals(radius, 1.0, high, points=120)


FIG_5_1 = ("centralized", {"k_1": 1000.0}, "k_2")
POINTS = [
    (FIG_5_1, [2801, 447.8, None, None]),
    (("centralized", {"k_1": 1000.0, "b_2": 3.0}, "k_2"), [870.2, 256.5, 137.0, 84.17]),
    (("distributed", {"k_11": 2000.0, "k_o": 1000.0}, "k_12"), [3462, 2068, 1276, 767.1]),
    (("distributed", {"k_11": 2000.0, "k_12": 300.0}, "k_o"), [11090, 5428, 2607, 1644]),
    (("distributed", {"k_o": 1000.0, "k_22": 2000.0}, "k_12"), [3462, 2068, 1276, 767.1]),
]


@pytest.mark.parametrize(("loop", "printed"), POINTS)
def test_one_point_of_each_figure(
    loop: tuple[Architecture, dict[str, float], str], printed: list[float | None]
) -> None:
    for n, limit in enumerate(printed):
        found = intervals(*loop, n)
        if limit is None:
            assert found == []
        else:
            assert len(found) == 1
            assert f"{found[0][1]:.4g}" == f"{limit:.4g}"


def test_stable_region_is_re_entrant() -> None:
    """k_12 = 1000 at n = 3: stable, then unstable, then stable again as k_11 grows (Fig. 5.2)."""
    first, second = intervals("distributed", {"k_12": 1000.0, "k_o": 1000.0}, "k_11", 3)
    assert [f"{value:.0f}" for value in (*first, *second)] == ["1", "431", "16616", "21658"]


@pytest.mark.parametrize("k_11", [430.5, 431.5, 16615.0, 16618.0, 21657.0, 21660.0])
def test_edges_are_confirmed_by_the_tick_by_tick_simulation(k_11: float) -> None:
    given = {"k_11": k_11, "k_12": 1000.0, "k_o": 1000.0}
    model = Parameters("distributed", given, CHAPTER_5["distributed"]).model()
    simulated = decisive_spectrum(*monodromy(model, timing(3))).radius
    assert (simulated < 1) == (k_11 in {430.5, 16618.0, 21657.0})


def test_an_island_between_two_samples_is_found() -> None:
    def radius(value: float) -> float:
        return 1.0 + 1e-3 * ((value - 3333.3) ** 2 - 0.04)

    ((start, stop),) = stable_intervals(radius, 1.0, 10000.0, points=100)
    assert (start, stop) == pytest.approx((3333.1, 3333.5), abs=1e-6)


def test_rho_of_a_rational_ratio_lies_between_its_neighbours() -> None:
    parameters = Parameters("distributed", {"k_12": 900.0}, CHAPTER_5["distributed"])
    radii = [
        stability(
            parameters.model(),
            Timing(ratio=ratio, delay=PathDelay.round_trip(1), sampling="between_ticks"),
        ).spectral_radius
        for ratio in (Fraction(8), Fraction(17, 2), Fraction(9))
    ]
    assert radii == sorted(radii)
    assert np.ptp(radii) > 1e-4


def test_an_empty_range_is_refused() -> None:
    with pytest.raises(InputError, match="empty"):
        stable_intervals(lambda value: value, 5.0, 5.0)
