"""Past the thesis: scenarios meet their limits, and theory says where a grasp breaks."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.analysis.modes import centralized_modes, distributed_modes, modes
from cosim.scenario import load
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.claims.statement import runs_of
from cosim.thesis.claims.verdict import decide
from cosim.thesis.expected.single_axis import net_force_amplitude
from cosim.thesis.experiments import in_parallel, run_one
from cosim.thesis.pages.beyond_figures import FIGURES, draw_beyond
from cosim.thesis.pages.findings import FINDINGS, BeyondPart
from cosim.thesis.pages.html import write_page
from cosim.thesis.results import Results
from cosim.thesis.sweeps import breaking
from cosim.thesis.sweeps.beyond import RADIUS_DELAYS, Beyond, radii_of
from cosim.thesis.sweeps.breaking import CENTRALIZED, CURVES, DELAYS, DISTRIBUTED, Limit, predict
from cosim.thesis.sweeps.free_motions import DELAYS as PREDICTED_DELAYS
from cosim.thesis.sweeps.free_motions import PREDICTORS, REALISM, prediction
from cosim.thesis.sweeps.trials import Motion, Steadiness, free_motion
from tests.support.experiments import NUMBERS, measured_of


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beyond")
    return {
        name: run_one(name, file, sets, folder / name).summary
        for name, (file, sets) in runs_of(EXTENSIONS).items()
    }


def measured(summary, target):
    return next(one["measured"] for one in summary["expectations"] if one["target"] == target)


@pytest.mark.timeout(600)
def test_every_extension_does_what_its_statement_says(summaries):
    decided = decide(summaries, {}, EXTENSIONS)
    assert {item.statement.name: item.verdict for item in decided} == {
        statement.name: "agree" for statement in EXTENSIONS
    }


def test_the_numbers_of_the_docs_are_what_was_measured(summaries):
    """Made anew by ``cohaptic thesis --page docs/experiments.md``."""
    stored = Results.read(NUMBERS)
    for name, summary in summaries.items():
        assert measured_of(summary) == pytest.approx(measured_of(stored.runs[name]), rel=1e-5), name


def test_each_piece_of_evidence_is_an_expectation_of_its_scenario():
    for statement in EXTENSIONS:
        for evidence in statement.evidence:
            expected = load(f"thesis/{evidence.scenario}").expect
            assert any(evidence.label in windows for windows in expected.values()), evidence


def test_passivity_layers_at_least_halve_the_limit_cycle(summaries):
    plain = measured(summaries["grasp_centralized"], "force_ripple")
    for name in ("passive", "wave"):
        assert measured(summaries[f"grasp_centralized_{name}"], "force_ripple") < plain / 2


def test_a_deadband_of_a_tenth_saves_four_packets_in_five(summaries):
    summary = summaries["grasp_deadband"]
    sent, due = (measured(summary, f"vr_a.packets_{which}") for which in ("sent", "due"))
    assert due == 1280
    assert sent <= due / 5


@pytest.mark.parametrize("delay", [1, 3])
def test_the_grasp_breaks_near_the_stiffness_that_the_theory_has(delay):
    predicted = predict("stiffness", delay)
    assert breaking.holds(CENTRALIZED, delay, stiffness=0.7 * predicted)
    assert not breaking.holds(CENTRALIZED, delay, stiffness=1.3 * predicted)


def test_jitter_breaks_the_grasp_near_the_stiffness_of_mean_square_theory():
    predicted = predict("jitter", 2)
    assert predicted < 0.5 * predict("jitter", 0)
    assert breaking.holds(CENTRALIZED, 0, stiffness=0.7 * predicted, jitter=2)
    assert not breaking.holds(CENTRALIZED, 0, stiffness=1.4 * predicted, jitter=2)


def test_the_grasp_breaks_near_the_critical_loss():
    predicted = predict("centralized_loss", 1)
    assert 0.3 < predicted < 0.5
    assert breaking.holds(CENTRALIZED, 1, loss=predicted - 0.15)
    assert not breaking.holds(CENTRALIZED, 1, loss=predicted + 0.15)


def test_no_loss_makes_the_distributed_grasp_unstable_and_tracking_is_what_ends_it():
    assert predict("distributed_loss", 1) is None
    assert breaking.holds(DISTRIBUTED, 1, loss=0.5)
    assert not breaking.holds(DISTRIBUTED, 1, loss=0.95)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_every_limit_is_near_the_prediction():
    for delay in DELAYS["stiffness"]:
        limit = breaking.find_limit("stiffness", delay)
        assert limit.found == pytest.approx(limit.predicted, rel=0.3)
    for delay in DELAYS["centralized_loss"]:
        limit = breaking.find_limit("centralized_loss", delay)
        assert limit.found == pytest.approx(limit.predicted, abs=0.1)


def test_a_grasp_holds_while_nothing_is_lost_and_forces_are_steady():
    assert Steadiness(0, 0.5).holds
    assert not Steadiness(1, 0.1).holds
    assert not Steadiness(0, 0.51).holds


def test_the_modes_are_those_of_the_planar_box():
    server = load(CENTRALIZED).components["server"]
    assert modes(server)["turn"].mass == pytest.approx(6.7e-4 / 0.05**2)
    timing = Timing(delay=PathDelay.round_trip(1))
    found = centralized_modes(server)
    assert set(found) == {"squeeze", "carry", "lift", "turn"}
    stiff = centralized_modes(server, remote_stiffness=800.0)
    for name, model in found.items():
        assert stability(model, timing).stable
        assert not stability(stiff[name], timing).stable
        assert model.stiffness[1] * 800 / 170 == pytest.approx(stiff[name].stiffness[1])


def test_hands_that_hold_on_change_the_distributed_grasp_too():
    held = distributed_modes(load(DISTRIBUTED))
    assert {model.hand_stiffness for model in held.values()} == {200.0}
    assert all(model.grounded for model in held.values())


@pytest.mark.parametrize("users", [2, 3, 4])
def test_two_to_four_users_are_stable_at_every_delay(users):
    radii = radii_of(users)
    assert len(radii) == len(RADIUS_DELAYS)
    assert max(radii) < 0.98


def test_ideal_devices_leave_the_force_of_the_independent_computation_and_no_ripple():
    built, ideal = (free_motion(REALISM[name]) for name in ("as built", "all ideal"))
    assert ideal.net_force == pytest.approx(net_force_amplitude(1, 0.0), rel=0.03)
    assert ideal.ripple < 2e-3 < built.ripple / 5


def test_holding_agrees_with_the_independent_computation_and_prediction_takes_half_away():
    held, linear = (free_motion(prediction(name, 2)) for name in PREDICTORS)
    assert held.net_force == pytest.approx(net_force_amplitude(2, 0.0), rel=0.1)
    assert linear.net_force < held.net_force / 2
    assert linear.ripple > held.ripple


def test_tasks_come_back_in_their_order():
    assert in_parallel([(divmod, (7, n)) for n in (3, 2, 5)], workers=2) == [(2, 1), (3, 1), (1, 2)]


def test_the_second_part_shows_every_figure_with_its_numbers(tmp_path):
    motion = Motion(net_force=0.4321, ripple=0.012, drift=0.003)
    found = Beyond(
        limits={
            curve: tuple(
                Limit(curve, n, None if curve == "distributed_loss" else 0.4, 0.375, 0.4375)
                for n in DELAYS[curve]
            )
            for curve in CURVES
        },
        realism=dict.fromkeys(REALISM, motion),
        predictors={(name, n): motion for name in PREDICTORS for n in PREDICTED_DELAYS},
        radii={users: tuple(np.linspace(0.9, 0.95, 5)) for users in (2, 3, 4)},
    )
    figures = draw_beyond(found, tmp_path)
    assert set(figures) == set(FIGURES) == set(FINDINGS)
    write_page(
        tmp_path / "page.html",
        [],
        wanted={},
        runs={},
        figures={},
        beyond=BeyondPart(decide({}, {}, EXTENSIONS), found, figures),
    )
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count("data:image/png") == len(FIGURES)
    assert page.count("<article") == len(EXTENSIONS)
    assert "0.432 N" in page
    assert "0.38 and 0.44" in page
    assert found.as_json()["limits"]["stiffness"][0]["breaks"] == 0.4375
