"""Every number that three independent computations agree on, to all its printed digits."""

from __future__ import annotations

from fractions import Fraction

import pytest

from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import CHAPTER_5, TABLE_6_1, WALL, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability, stable_intervals
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import (
    centralized_damping_two_samples,
    distributed_damping_two_samples,
    limit_damping,
    original_damping_two_samples,
    uniform_compensation,
)
from cosim.theory.transparency.stiffness import distributed_stiffness, equivalent_stiffness


def timing(n: int, ratio: int = 8, computation_delay: int = 0) -> Timing:
    return Timing(
        ratio=Fraction(ratio), delay=PathDelay.round_trip(n), computation_delay=computation_delay
    )


def table_6_1(architecture: Architecture, one_hand: int, **values: float) -> Model:
    users = (one_hand == 0, one_hand == 1)
    return Parameters(architecture, values, TABLE_6_1[architecture]).model(users)


def digits(value: float, places: int) -> str:
    """The value as it would be printed with so many significant digits."""
    return f"{value:.{places}g}"


@pytest.mark.parametrize(
    ("damping", "computation_delay", "printed", "places"),
    [(10, 0, 20480, 7), (15, 0, 30720, 7), (10, 1, 6434.7, 5), (15, 1, 9331, 4)],
)
def test_single_user_stiffness_limit(
    damping: float, computation_delay: int, printed: float, places: int
) -> None:
    base = Parameters("single", {"b": damping}, CHAPTER_5["single"], users=1)
    tick = timing(0, ratio=1, computation_delay=computation_delay)

    def radius(k: float) -> float:
        return stability(base.replaced({"k": k}).model(), tick).spectral_radius

    ((_, limit),) = stable_intervals(radius, 1.0, 50000.0)
    assert digits(limit, places) == digits(printed, places)


@pytest.mark.parametrize("n", range(4))
def test_b_10_holds_at_any_delay(n: int) -> None:
    felt = limit_damping(table_6_1("centralized", 1), timing(n, ratio=2), 1)
    assert digits(felt, 5) == "0.041656"
    assert felt == pytest.approx(centralized_damping_two_samples(0.4, 85, 3, 1 / 1024), rel=1e-10)


def test_equation_6_3() -> None:
    model = table_6_1("distributed", 0)
    felt = limit_damping(model, timing(0, ratio=2), 0, "simplified")
    assert digits(felt, 6) == "0.148321"
    assert felt == pytest.approx(distributed_damping_two_samples(0.4, 300, 10, 1 / 1024), rel=1e-10)


def test_b_11_to_b_13_hold_for_one_sample_of_delay() -> None:
    felt = limit_damping(table_6_1("distributed", 0), timing(1, ratio=2), 0)
    assert digits(felt, 7) == "0.8361246"
    closed = original_damping_two_samples(
        T_c=1 / 1024, m_1=0.1, m_o=0.4, k_11=3000, b_11=20, k_12=400, b_12=2, k_o=300, b_o=10
    )
    assert felt == pytest.approx(closed, rel=1e-10)
    assert digits(limit_damping(table_6_1("distributed", 0), timing(0, ratio=2), 0), 4) == "0.2819"


def test_table_6_2() -> None:
    remote = table_6_1("centralized", 1)
    assert digits(limit_damping(remote, timing(0), 1), 4) == "0.2937"
    assert digits(limit_damping(remote, timing(0, ratio=2), 1), 3) == "0.0417"
    copies = table_6_1("distributed", 0)
    assert digits(limit_damping(copies, timing(0), 0), 4) == "2.039"
    assert digits(limit_damping(copies, timing(0), 0, "simplified"), 4) == "1.067"
    stiffer = table_6_1("distributed", 0, k_o=400)
    assert digits(limit_damping(stiffer, timing(0), 0, "simplified"), 4) == "1.425"
    assert abs(limit_damping(remote, timing(0), 1, "simplified")) < 1e-12


@pytest.mark.parametrize(("n", "printed"), [(0, "1.509"), (1, "3.15"), (2, "4.79")])
def test_compensation_that_nulls_table_6_1(n: int, printed: str) -> None:
    found = null_compensation(table_6_1("distributed", 0), timing(n), 0)
    assert digits(-found.value, 4) == printed
    assert found.compensated.stable
    assert found.compensated.marginal


@pytest.mark.parametrize(("n", "printed"), [(0, "0.877"), (1, "1.844"), (2, "2.811")])
def test_compensation_of_the_platform_with_both_hands_on_the_box(n: int, printed: str) -> None:
    gains = {
        "k_11": 800 / 1,
        "b_11": 3,
        "k_12": 170,
        "b_12": 3,
        "k_o": 77.5,
        "b_o": 10,
    }
    model = Parameters("distributed", gains, TABLE_6_1["distributed"]).model()
    found = null_compensation(model, timing(n), 0)
    assert f"{-found.value:.3f}" == printed
    assert found.compensated.stable


def test_three_newton_seconds_per_metre_overcompensate_at_no_delay() -> None:
    model = uniform_compensation(table_6_1("distributed", 0), -3.0)
    assert f"{stability(model, timing(0)).spectral_radius:.4f}" == "1.0230"


def test_stiffness_in_rigid_contact() -> None:
    copies = table_6_1("distributed", 0, **WALL)
    assert f"{equivalent_stiffness(copies, 0):.2f}" == "2729.35"
    closed = distributed_stiffness(3000, 400, 300, 30000)
    assert equivalent_stiffness(copies, 0) == pytest.approx(closed.corrected, rel=1e-12)
    assert closed.as_printed != pytest.approx(closed.corrected, rel=1e-6)
    assert f"{equivalent_stiffness(table_6_1('centralized', 1, **WALL), 1):.2f}" == "84.76"
    assert f"{equivalent_stiffness(table_6_1('centralized', 0, **WALL), 0):.2f}" == "967.74"


@pytest.mark.parametrize(
    ("k_1", "k_2", "b", "printed"),
    [
        (800, 800, 3, ".96474 1.19967 1.27055 1.27633"),
        (1200, 1200, 10, ".94795 1.27436 1.36320 1.34879"),
        (800, 170, 3, ".99249 .99248 1.02977 1.07939"),
    ],
)
def test_gains_of_the_centralized_experiments(
    k_1: float, k_2: float, b: float, printed: str
) -> None:
    given = {"k_1": k_1, "k_2": k_2, "b": b}
    model = Parameters("centralized", given, CHAPTER_5["centralized"]).model()
    found = [f"{stability(model, timing(n)).spectral_radius:.5f}" for n in range(4)]
    assert " ".join(found).replace("0.", ".") == printed
