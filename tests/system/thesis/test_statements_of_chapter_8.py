"""Every statement of chapter 8 is decided by a measurement, and none is contradicted.

The measured forces are also held against a computation that knows nothing of the product.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cosim.analysis import load_tuned
from cosim.base.quantities.quantity import quantity
from cosim.run import run_scenario
from cosim.scenario import load
from cosim.thesis import breaking
from cosim.thesis.beyond import radii_of
from cosim.thesis.experiments import run_one
from cosim.thesis.extensions import EXTENSIONS
from cosim.thesis.figures import FIGURES, draw_figures
from cosim.thesis.page import write_page
from cosim.thesis.predictions import PREDICTIONS
from cosim.thesis.single_axis import net_force_amplitude
from cosim.thesis.statements import EXPERIMENTS, STATEMENTS, ablation_runs, decide
from cosim.thesis.table import with_table

PAGE = Path(__file__).parents[3] / "docs" / "experiments.md"
NET_FORCE = "vr_a.finger_1.normal_force - vr_b.finger_1.normal_force"


def entry(summary, target, label):
    return next(
        one for one in summary["expectations"] if one["target"] == target and one["label"] == label
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thesis")
    found = {name: run_one(name, f"thesis/{name}", (), folder / name) for name in EXPERIMENTS}
    for name, (file, sets) in ablation_runs(STATEMENTS).items():
        found[name] = run_one(name, file, sets, folder / name)
    return found


@pytest.fixture(scope="module")
def summaries(runs):
    return {name: ran.summary for name, ran in runs.items()}


@pytest.mark.timeout(600)
def test_every_statement_is_agreed_with_that_a_simulation_can_decide(summaries):
    decided = decide(summaries, {})
    assert {item.statement.name: item.verdict for item in decided} == {
        statement.name: "cannot be decided" if statement.undecidable else "agree"
        for statement in STATEMENTS
    }
    assert [item.statement.name for item in decided if item.statement.undecidable] == [
        "users-notice"
    ]


def test_each_ablation_fails_its_statement(summaries):
    for item in decide(summaries, {}):
        for ablated in item.ablated:
            assert ablated.passed is False, (item.statement.name, ablated.evidence)


def test_every_statement_and_every_piece_of_evidence_has_an_ablation_that_must_fail():
    """A piece of evidence for several statements has it with one of them."""
    decidable = [each for each in (*STATEMENTS, *EXTENSIONS) if not each.undecidable]
    assert all(statement.ablations for statement in decidable)

    def what(parts):
        return {(part.scenario, part.label) for part in parts}

    ablated = what(each.evidence for statement in decidable for each in statement.ablations)
    assert ablated == what(part for statement in decidable for part in statement.evidence)


def test_every_limit_has_an_origin_and_the_computed_ones_are_the_scenarios():
    for statement in (*STATEMENTS, *EXTENSIONS):
        for evidence in statement.evidence:
            assert (evidence.scenario, evidence.label) in PREDICTIONS, evidence
    for (scenario, label), prediction in PREDICTIONS.items():
        if prediction.value is None:
            continue
        value = prediction.value()
        limits = [
            float(quantity(limit, unit))
            for target, windows in load(f"thesis/{scenario}").expect.items()
            for key, pair in windows.get(label, {}).items()
            if key.endswith("_within")
            for unit in ("m" if "position" in target else "1",)
            for limit in pair
        ]
        wanted = [value * (1 + sign * prediction.tolerance) for sign in (-1, 1)]
        assert sorted(map(abs, limits)) == pytest.approx(wanted, rel=0.01), scenario


def test_limits_that_an_ablation_meets_as_well_decide_nothing(summaries):
    harmless = {
        name: summaries.get(name.partition("_without")[0], summary)
        for name, summary in summaries.items()
    }
    verdicts = {item.statement.name: item.verdict for item in decide(harmless, {})}
    assert verdicts["centralized-unstable"] == "cannot be decided"


def test_a_folder_called_thesis_does_not_hide_the_bundled_scenarios(tmp_path, monkeypatch):
    """As where the page itself goes to: ``cohaptic thesis --out thesis``."""
    hidden = ("rigid_contact", "grasp_centralized_soft", "grasp_distributed", "four_users")
    for name in hidden:
        (tmp_path / "thesis" / name).mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    ran = run_one("rigid_contact", "thesis/rigid_contact", (), tmp_path / "out")
    assert ran.failure == ""
    breaking.soft_stiffness.cache_clear()
    assert breaking.soft_stiffness() == (170.0, 270.0)
    assert breaking.predict("stiffness", 4) == pytest.approx(57, abs=1)
    assert breaking.predict("centralized_loss", 3) == 0.0
    assert breaking.predict("distributed_loss", 2) is None
    assert max(radii_of(4)) < 1.0


@pytest.mark.parametrize(
    ("scenario", "label", "compensation"),
    [
        ("free_motion", "uncompensated", 0.0),
        ("free_motion_compensated", "compensated", -1.8441),
        ("free_motion_printed", "printed", -0.88),
    ],
)
def test_the_net_force_is_that_of_an_independent_computation(
    summaries, scenario, label, compensation
):
    measured = entry(summaries[scenario], NET_FORCE, label)["measured"]
    assert measured == pytest.approx(net_force_amplitude(1, compensation), rel=0.1)


@pytest.mark.parametrize(("round_trip", "null"), [(0, -0.8773), (2, -2.8109)])
def test_other_delays_agree_with_it_too(tmp_path: Path, round_trip, null):
    for label, choice, compensation in (("uncompensated", "~", 0.0), ("auto", "auto", null)):
        sets = [f"channels.lan.round_trip_delay={round_trip}"]
        if choice == "auto":
            sets += [f"components.vr_{name}.parameters.compensation=auto" for name in "ab"]
        summary = run_scenario(
            load_tuned("thesis/free_motion", (), sets), tmp_path / label, figure=False
        ).summary.content
        measured = entry(summary, NET_FORCE, "uncompensated")["measured"]
        assert measured == pytest.approx(net_force_amplitude(round_trip, compensation), rel=0.1)


def test_the_page_shows_every_statement_measurement_and_figure(runs, summaries, tmp_path: Path):
    figures = {name: tmp_path / file for name, file in draw_figures(runs, tmp_path).items()}
    assert set(figures) == set(FIGURES)
    write_page(tmp_path / "thesis.html", decide(summaries, {}), runs, figures)
    page = (tmp_path / "thesis.html").read_text(encoding="utf-8")
    assert page.count("<article") == len(STATEMENTS)
    assert page.count("data:image/png") == len(FIGURES)
    assert "not measured" not in page


def test_each_piece_of_evidence_is_an_expectation_of_its_scenario():
    for statement in STATEMENTS:
        for evidence in statement.evidence:
            expected = load(f"thesis/{evidence.scenario}").expect
            assert any(evidence.label in windows for windows in expected.values()), evidence


def test_a_statement_without_a_run_is_not_decided_and_one_that_fails_is_disagreed_with():
    assert {item.verdict for item in decide({}, {})} == {"cannot be decided"}
    failing = {
        name: {
            "expectations": [
                {"label": evidence.label, "measured": 1.0, "passed": False}
                for statement in STATEMENTS
                for evidence in statement.evidence
                if evidence.scenario == name
            ]
        }
        for name in EXPERIMENTS
    }
    assert {item.verdict for item in decide(failing, {}) if not item.statement.undecidable} == {
        "disagree"
    }


def test_the_page_of_the_docs_has_what_was_measured(summaries):
    """Written with COHAPTIC_WRITE_DOCS=1."""
    decided = decide(summaries, {})
    page = PAGE.read_text(encoding="utf-8")
    wanted = with_table(page, decided)
    if os.environ.get("COHAPTIC_WRITE_DOCS"):
        PAGE.write_text(wanted, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == wanted
