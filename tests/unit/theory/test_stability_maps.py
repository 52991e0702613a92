"""Whole stability maps by the Schur–Cohn test equal eigenvalues, cell by cell."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.theory.chapters.chapter_5 import DELAYS, FIGURES, StabilityFigure
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.models.station import Station, hand_alone, object_station
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.map import Axis, stability_maps
from cosim.theory.stability.schur_cohn import all_roots_inside, divide_by_z_minus_one, multiply
from cosim.theory.stability.spectral_radius import stability


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
                    PathDelay.round_trip(n),
                    timing.computation_delay,
                )
                cells[number, row, column] = stability(model, timed).stable
    return cells


@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_no_cell_of_a_figure_differs(figure: StabilityFigure) -> None:
    x, y = figure.axes(points=11)
    fast = stability_maps(figure.parameters(), Timing(), x, y, DELAYS)
    assert np.array_equal(fast, by_eigenvalues(figure.parameters(), Timing(), x, y, DELAYS))


def resampled(station: Station, sent: np.ndarray) -> tuple[np.ndarray, ...]:
    """A^N, Σ Aⁱ B, what is sent and its feedthrough, for N = 8 and all cells at once."""
    held, power = np.zeros_like(station.B[..., :1]), np.eye(station.A.shape[-1])
    for _ in range(8):
        held = held + power @ station.B[..., :1]
        power = station.A @ power
    through = station.D[..., :1, :1] if sent is station.C else np.zeros((1, 1))
    return power, held, sent, through


def batched_radius(one: tuple[np.ndarray, ...], two: tuple[np.ndarray, ...], n: int) -> np.ndarray:
    """Close two stations over a delay of ⌈n/2⌉ to the first and ⌊n/2⌋ back; eigenvalues, cells
    first, less the one nearest to 1."""
    (A, B, C, D), (E, F, G, _) = one, two
    up, down = n - n // 2, n // 2
    a, e = A.shape[-1], E.shape[-1]
    M = np.zeros((*np.broadcast(A[..., 0, 0], E[..., 0, 0]).shape, a + e + n, a + e + n))
    M[..., :a, :a], M[..., a : a + e, a : a + e] = A, E
    heard = np.zeros((*M.shape[:-2], 1, a + e + n))
    if up:
        heard[..., 0, a + e + up - 1] = 1
        M[..., a + e, a : a + e] = G[..., 0, :]
        for i in range(1, up):
            M[..., a + e + i, a + e + i - 1] = 1
    else:
        heard[..., :, a : a + e] = G
    M[..., :a, :] += B @ heard
    answer = D @ heard
    answer[..., :, :a] += C
    first = a + e + up
    if down:
        M[..., a : a + e, first + down - 1] += F[..., 0]
        M[..., first, :] = answer[..., 0, :]
        for i in range(1, down):
            M[..., first + i, first + i - 1] = 1
    else:
        M[..., a : a + e, :] += F @ answer
    values = np.linalg.eigvals(M)
    nearest = np.argmin(np.abs(values - 1), axis=-1)
    np.put_along_axis(values, nearest[..., None], 0, axis=-1)
    return np.max(np.abs(values), axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("n", DELAYS)
@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_no_cell_of_a_full_figure_differs(figure: StabilityFigure, n: int) -> None:
    """201 x 201 cells against eigenvalues of the closed one-frame matrix."""
    x, y = figure.axes()
    fast = stability_maps(figure.parameters(), Timing(), x, y, [n])[0]
    p = {**figure.parameters().resolved()}
    p |= dict(zip((x.name, y.name), np.meshgrid(x.values, y.values), strict=True))
    common = {"compensation": 0.0, "period": 1 / 1024, "computation_delay": 0}
    if figure.architecture == "centralized":
        server = object_station(
            hand=(0.1, 0.0),
            local=(p["k_1"], 10.0),
            object_mass=0.4,
            held=[(p["k_2"], 10.0)],
            **common,
        )
        client = hand_alone(0.1, 0.0, period=1 / 1024)
        sent = np.stack(np.broadcast_arrays(p["k_2"], 10.0), axis=-1)[..., None, :]
        ends = resampled(server, server.C), resampled(client, sent)
    else:
        # A name of a pair stands for both of its couplers.
        k_12, k_o = p["k_12"], p.get("k_o", p["k_o1"])
        copy = object_station(
            hand=(0.1, 0.0),
            local=(p["k_11"], 10.0),
            object_mass=0.4,
            held=[(k_12 + k_o, 20.0)],
            **common,
        )
        sent = np.stack(np.broadcast_arrays(k_12, 10.0, k_o, 10.0), axis=-1)[..., None, :]
        ends = resampled(copy, sent), resampled(copy, sent)
    assert np.array_equal(fast, batched_radius(*ends, n) < 1)


@pytest.mark.parametrize(
    ("architecture", "given", "x", "y", "timing"),
    [
        ("single", {}, ("k", 40000.0), ("b", 40.0), Timing(ratio=Fraction(1))),
        (
            "single",
            {"b_h": 0.5},
            ("k", 40000.0),
            ("b", 40.0),
            Timing(Fraction(1, 1024), Fraction(1), PathDelay(), 1),
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
            Timing(Fraction(1, 1024), Fraction(8), PathDelay(), 2),
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
