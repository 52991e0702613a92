"""Whatever order packets come in: a run's bounds are the closed form's, and the kernel grows so.

Set beforehand: on one axis 1e-8; the kernel's growth with the worst packets 1e-6 of the lower one;
joins prove a bound of their own, which no product exceeds.
"""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.analysis.answers.asked import AskedRun, ask
from cosim.analysis.answers.orders import bursts_run, switching_run
from cosim.base.errors import InputError
from cosim.cli.theory.robust.bursts import command as bursts
from cosim.cli.theory.robust.switching import command as switching
from cosim.scenario.load import read
from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import spectral_radius
from cosim.theory.robust import lyapunov
from cosim.theory.robust.automaton import Automaton, Edge
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.network import bounded_bursts, switching_delays
from cosim.theory.robust.reduction import reduced

ONE_AXIS = "single_axis_centralized"
STILL = ["components.step_1.parameters.amplitude=0"]
SERVER = "components.server.parameters.remote"
HELD = [f"{SERVER}_normal_stiffness=170", f"{SERVER}_tangential_stiffness=270"]


def closed_form() -> Parameters:
    return Parameters("centralized", {}, TABLE_6_1["centralized"])


@pytest.fixture(name="asked")
def _asked() -> Iterator[AskedRun]:
    with ask(read(ONE_AXIS, (), [*STILL, "channels.lan.round_trip_delay=1"])) as asked:
        yield asked


def test_bursts_of_a_run_are_those_of_its_loop(asked: AskedRun) -> None:
    orders = bursts_run(asked, 1, "independent")
    found = orders.joint_radius()
    timing = Timing(delay=PathDelay.round_trip(1))
    wanted = joint_radius(bounded_bursts(closed_form().model(), timing, 1)[0])
    assert found.verdict == wanted.verdict == "unstable"
    assert found.lower == pytest.approx(wanted.lower, abs=1e-8)
    assert orders.kernel_growth(found.word) == pytest.approx(found.lower, rel=1e-6)


def test_delays_that_alternate_grow_in_the_run_and_in_the_kernel(asked: AskedRun) -> None:
    orders = switching_run(asked, (0, 1), (0, 1))
    with orders.point:
        found = orders.joint_radius()
        wanted = joint_radius(
            switching_delays(closed_form().model(), Timing(), (0, 1), (0, 1), freshest=True)[0]
        )
        assert max(orders.fixed().values()) < 0.99625
        assert found.lower == pytest.approx(1.000628, abs=1e-6)
        assert found.lower == pytest.approx(wanted.lower, abs=1e-8)
        assert orders.kernel_growth(found.word) == pytest.approx(found.lower, rel=1e-6)


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param("bursts", marks=pytest.mark.slow),
        pytest.param("switching", marks=pytest.mark.exhaustive),
    ],
)
def test_a_planar_run_is_bounded_and_grows_as_said(kind: str) -> None:
    with ask(read("two_users_box_centralized", (), [*HELD, "channels.lan.each_way_delay=0"])) as it:
        if kind == "bursts":
            orders = bursts_run(it, 1, "together")
            found = orders.joint_radius()
            growth = orders.kernel_growth(found.word)
        else:
            orders = switching_run(it, (0, 1), (0,))
            with orders.point:
                found = orders.joint_radius()
                growth = orders.kernel_growth(found.word)
                assert max(orders.fixed().values()) <= found.lower * (1 + 1e-9)
    assert found.verdict == "stable"
    assert growth == pytest.approx(found.lower, rel=1e-6)
    assert found.lower <= found.upper <= found.quadratic


def test_without_a_set_jitter_says_what_may_come() -> None:
    with ask(read(ONE_AXIS, (), [*STILL, "channels.lan.jitter=3 ticks"])) as asked:
        orders = switching_run(asked, None, None)
        with orders.point:
            assert {len(ticks) for ticks in orders.ticks} == {4}


@pytest.mark.parametrize(
    ("command", "options", "said"),
    [
        (switching, ["--set", "channels.lan.loss=0.1"], "lan.forward loses packets"),
        (switching, ["--freshest"], "leave --freshest out"),
        (switching, ["--delays", "0,x"], "whole network samples"),
        (bursts, ["--set", "channels.lan.jitter=1"], "lan.forward has jitter"),
    ],
)
def test_what_is_no_question_is_refused_by_name(command, options: list[str], said: str) -> None:
    found = CliRunner().invoke(command, ["--scenario", ONE_AXIS, *options])
    assert isinstance(found.exception, InputError)
    assert said in str(found.exception)


def test_the_command_says_what_the_kernel_does() -> None:
    found = CliRunner().invoke(switching, ["--scenario", ONE_AXIS, "--delays", "0,1", "--json"])
    assert found.exit_code == 0, found.output
    answer = json.loads(found.stdout)
    assert answer["verdict"] == "unstable"
    assert answer["kernel_growth"] == pytest.approx(answer["lower"], rel=1e-6)


def graph(seed: int, order: int) -> Automaton:
    maps = np.random.default_rng(seed).normal(size=(3, order, order)) / np.sqrt(order)
    # 0 → 1 → 0 by the first two, and the third stays in 1.
    return Automaton(maps, (Edge(0, 1, 0), Edge(1, 0, 1), Edge(1, 1, 2)), 2)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=3, deadline=None)
def test_joins_prove_what_no_product_exceeds(seed: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lyapunov, "MOST_UNKNOWNS", 0)
        automaton = graph(seed, 4)
        found = joint_radius(automaton, 1e-3, 8)
    assert found.lower <= found.upper <= found.quadratic * (1 + 1e-9)
    for stays in range(6):
        stay = np.linalg.matrix_power(automaton.maps[2], stays)
        product = automaton.maps[1] @ stay @ automaton.maps[0]
        assert spectral_radius(product) ** (1 / (stays + 2)) <= found.upper * (1 + 1e-9)


def test_joins_come_near_to_the_best_quadratic_norm() -> None:
    automaton = graph(5, 4)
    best = lyapunov.certificate(automaton, 0.0).radius
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lyapunov, "MOST_UNKNOWNS", 0)
        joined = lyapunov.certificate(automaton, 0.0).radius
    assert joined < 1.05 * best


def test_a_reduction_keeps_what_lasts() -> None:
    slow = np.diag([0.9, 0.8, *np.linspace(0.01, 0.1, 20)])
    mixing = np.random.default_rng(1).normal(size=slow.shape)
    maps = np.array([np.linalg.solve(mixing, slow @ mixing)])
    small = reduced(Automaton(maps, (Edge(0, 0, 0),)), 8)
    assert small.maps.shape == (1, 8, 8)
    assert spectral_radius(small.maps[0]) == pytest.approx(0.9, abs=1e-3)
