"""Every statement of chapter 8 is decided by a measurement, and none is contradicted.

The measured forces are also held against a computation that knows nothing of the product.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.analysis import load_tuned
from cosim.base.quantities.quantity import quantity
from cosim.cli import cli
from cosim.report.expectation_form import COMPARISONS
from cosim.run import run_scenario
from cosim.scenario import load
from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability, stable_intervals
from cosim.thesis.claims.chapter_8 import STATEMENTS
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.claims.statement import runs_of
from cosim.thesis.claims.verdict import decide
from cosim.thesis.expected.impact import WALL, WALL_DAMPING
from cosim.thesis.expected.predictions import PREDICTIONS
from cosim.thesis.expected.single_axis import net_force_amplitude
from cosim.thesis.experiments import run_one
from cosim.thesis.pages.figures import FIGURES, draw_figures
from cosim.thesis.pages.html import write_page
from cosim.thesis.results import Results
from cosim.thesis.sweeps import breaking
from cosim.thesis.sweeps.beyond import radii_of
from tests.support.experiments import NUMBERS, measured_of

NET_FORCE = "vr_a.finger_1.normal_force - vr_b.finger_1.normal_force"


def entry(summary, target, label):
    return next(
        one for one in summary["expectations"] if one["target"] == target and one["label"] == label
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thesis")
    return {
        name: run_one(name, file, sets, folder / name)
        for name, (file, sets) in runs_of(STATEMENTS).items()
    }


@pytest.fixture(scope="module")
def summaries(runs):
    return {name: ran.summary for name, ran in runs.items()}


@pytest.mark.timeout(600)
def test_every_statement_is_agreed_with_that_a_simulation_can_decide(summaries):
    decided = decide(summaries, {}, STATEMENTS)
    assert {item.statement.name: item.verdict for item in decided} == {
        statement.name: "cannot be decided" if statement.undecidable else "agree"
        for statement in STATEMENTS
    }
    assert [item.statement.name for item in decided if item.statement.undecidable] == [
        "users-notice"
    ]


def test_each_ablation_fails_its_statement(summaries):
    for item in decide(summaries, {}, STATEMENTS):
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


LABELS = sorted(
    {(one.scenario, one.label) for each in (*STATEMENTS, *EXTENSIONS) for one in each.evidence}
)


def test_every_label_has_a_prediction_and_no_other_has():
    assert sorted(PREDICTIONS) == LABELS


@pytest.mark.parametrize(("scenario", "label"), LABELS, ids="-".join)
def test_each_limit_of_a_scenario_is_the_one_that_is_computed(scenario, label):
    units = {"mm": "m"}
    written = {
        (target, key): tuple(
            float(quantity(one, units.get(str(one).rpartition(" ")[2], "1")))
            for one in (value if isinstance(value, list | tuple) else [value])
        )
        for target, windows in load(f"thesis/{scenario}").expect.items()
        for key, value in windows.get(label, {}).items()
        if key.rpartition("_")[2] in COMPARISONS
    }
    prediction = PREDICTIONS[scenario, label]
    assert written == {
        (limit.target, limit.predicate): pytest.approx(limit.bounds(), rel=0.005)
        for limit in prediction.limits
    }
    assert prediction.derivation in prediction.sentence


def test_a_name_stands_for_one_run_alone():
    named: dict[str, set[tuple[str, tuple[str, ...]]]] = {}
    for statement in (*STATEMENTS, *EXTENSIONS):
        for each in statement.evidence:
            named.setdefault(each.run, set()).add((each.scenario, each.sets))
        for each in statement.ablations:
            named.setdefault(each.name, set()).add((each.evidence.scenario, each.sets))
    assert [name for name, runs in named.items() if len(runs) > 1] == []


def test_a_hand_on_a_box_that_a_wall_holds_is_stable_up_to_228_newtons_a_metre():
    """As the remark says; what is nearly the stiffest lies below, its ablation above."""
    given = {"k_1": 800.0, "b_1": 3.0, "b_2": 3.0, "k_w": WALL, "b_w": WALL_DAMPING}

    def radius(stiffness: float) -> float:
        parameters = Parameters(
            "centralized", {**given, "k_2": stiffness}, TABLE_6_1["centralized"]
        )
        timing = Timing(delay=PathDelay.round_trip(1))
        return stability(parameters.model((False, True)), timing).spectral_radius

    [(_, limit)] = stable_intervals(radius, 1.0, 2000.0, points=30)
    assert limit == pytest.approx(228.3, abs=0.1)
    assert radius(200.0) < 1.0 < radius(400.0)


def test_limits_that_an_ablation_meets_as_well_decide_nothing(summaries):
    harmless = {
        name: summaries.get(name.partition("_without")[0], summary)
        for name, summary in summaries.items()
    }
    verdicts = {item.statement.name: item.verdict for item in decide(harmless, {}, STATEMENTS)}
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
    write_page(
        tmp_path / "thesis.html",
        decide(summaries, {}, STATEMENTS),
        wanted=runs_of(STATEMENTS),
        runs=runs,
        figures=figures,
    )
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
    assert {item.verdict for item in decide({}, {}, STATEMENTS)} == {"cannot be decided"}
    failing = {
        name: {
            "expectations": [
                {"label": evidence.label, "measured": 1.0, "passed": False}
                for statement in STATEMENTS
                for evidence in statement.evidence
                if evidence.scenario == name
            ]
        }
        for name in runs_of(STATEMENTS)
    }
    assert {
        item.verdict for item in decide(failing, {}, STATEMENTS) if not item.statement.undecidable
    } == {"disagree"}


def test_the_numbers_of_the_docs_are_what_was_measured(summaries):
    """Made anew by ``cohaptic thesis --page docs/experiments.md``."""
    stored = Results.read(NUMBERS)
    for name, summary in summaries.items():
        assert measured_of(summary) == pytest.approx(measured_of(stored.runs[name]), rel=1e-5), name


@pytest.mark.exhaustive
def test_the_page_of_the_docs_is_what_its_command_writes(tmp_path):
    page = tmp_path / "experiments.md"
    done = CliRunner().invoke(
        cli, ["thesis", "--out", str(tmp_path / "thesis"), "--page", str(page), "--workers", "2"]
    )
    assert done.exit_code == 0, done.output
    for file in (page, page.with_suffix(".json")):
        wanted = NUMBERS.with_suffix(file.suffix)
        assert file.read_text(encoding="utf-8") == wanted.read_text(encoding="utf-8")
