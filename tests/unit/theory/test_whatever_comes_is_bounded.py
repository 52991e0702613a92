"""Bounds of the joint spectral radius meet the published ones, and no product exceeds them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import spectral_radius
from cosim.theory.robust.automaton import Automaton, Edge, arbitrary
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.lyapunov import certificate, verified
from cosim.theory.robust.network import bounded_bursts, switching_delays
from cosim.theory.stability.spectral_radius import stability

PARRILO_JADBABAIE = np.array(
    [
        [[0, 1, 7, 4], [1, 6, -2, -3], [-1, -1, -2, -6], [3, 0, 9, 1]],
        [[-3, 3, 0, -2], [-2, 1, 4, 9], [4, -3, 1, 1], [1, -5, -1, -2]],
        [[1, 4, 5, 10], [0, 5, 1, -4], [0, -1, 4, 6], [-1, 5, 0, 1]],
    ],
    dtype=np.float64,
)
"""Parrilo and Jadbabaie 2008, example 5.4."""
GRIPENBERG = np.array([[[3, 0], [1, 3]], [[3, -3], [0, -1]]]) / 5.0
"""Gripenberg 1996."""


def test_the_example_of_parrilo_and_jadbabaie():
    # A tenth of them: below 1 the bounds are taken to the last digit.
    found = joint_radius(arbitrary(PARRILO_JADBABAIE / 10))
    assert found.lower == pytest.approx(0.8914964, abs=1e-7)
    assert sorted(found.word) == [0, 2]
    assert found.quadratic == pytest.approx(0.97607, rel=2e-4)
    assert found.lower <= found.upper < 0.895


def test_the_example_of_gripenberg():
    found = joint_radius(arbitrary(GRIPENBERG))
    assert found.lower == pytest.approx(0.659679, abs=1e-6)
    assert found.upper == pytest.approx(0.659679, abs=2e-4)


def test_a_certificate_is_verified_and_a_smaller_radius_is_not():
    maps = arbitrary(PARRILO_JADBABAIE)
    found = certificate(maps, 8.9)
    assert verified(maps, found.norms, found.radius)
    assert not verified(maps, found.norms, 0.99 * found.radius)


def loop(architecture: str, **values: float):
    return Parameters(architecture, values, TABLE_6_1[architecture]).model()


def test_two_delays_that_are_stable_each_grow_when_they_alternate():
    model = loop("centralized")
    fixed = [
        stability(model, Timing(delay=PathDelay(i, j))).spectral_radius
        for i, j in itertools.product((0, 1), repeat=2)
    ]
    assert max(fixed) < 0.99625
    automaton, ages = switching_delays(model, Timing(), (0, 1), (0, 1))
    found = joint_radius(automaton)
    assert found.verdict == "unstable"
    assert found.lower == pytest.approx(1.000628, abs=1e-6)
    assert {ages[number] for number in found.word} == {(0, 1), (1, 0)}


def test_the_distributed_loop_is_stable_with_both_delays_in_any_order():
    automaton, _ = switching_delays(loop("distributed"), Timing(), (0, 1), (0, 1))
    found = joint_radius(automaton)
    assert found.verdict == "stable"
    assert found.upper < 0.9655


def test_a_receiver_that_keeps_the_freshest_packet_has_fewer_orders():
    model = loop("centralized", k_2=40.0)
    free, ages = switching_delays(model, Timing(), (0, 2), (0,))
    kept, _ = switching_delays(model, Timing(), (0, 2), (0,), freshest=True)
    assert len(kept.edges) < len(ages) ** 2
    assert joint_radius(kept).lower <= joint_radius(free).upper * (1 + 1e-9)


def test_lost_in_turns_a_single_packet_at_a_time_is_one_too_many():
    timing = Timing(delay=PathDelay(1, 0))
    alone = joint_radius(bounded_bursts(loop("centralized"), timing, 1, "together")[0])
    apart = joint_radius(bounded_bursts(loop("centralized"), timing, 1)[0])
    assert alone.verdict == "stable"
    assert apart.verdict == "unstable"


def test_no_losses_are_the_loop_itself():
    timing = Timing(delay=PathDelay(1, 1))
    model = loop("distributed")
    found = joint_radius(bounded_bursts(model, timing, 0)[0])
    assert found.lower == pytest.approx(stability(model, timing).spectral_radius, rel=1e-9)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=8, deadline=None)
def test_every_product_along_the_graph_stays_between_the_bounds(seed):
    rng = np.random.default_rng(seed)
    maps = rng.normal(size=(3, 3, 3)) / 2
    # 0 → 1 → 0 by the first two, and the third stays in 1.
    graph = Automaton(maps, (Edge(0, 1, 0), Edge(1, 0, 1), Edge(1, 1, 2)), 2)
    found = joint_radius(graph, 1e-3, 12)
    assert found.lower <= found.upper <= found.quadratic * (1 + 1e-9)
    for stays in range(6):
        product = maps[1] @ np.linalg.matrix_power(maps[2], stays) @ maps[0]
        assert spectral_radius(product) ** (1 / (stays + 2)) <= found.upper * (1 + 1e-9)
