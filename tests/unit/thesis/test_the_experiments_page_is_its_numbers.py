"""docs/experiments.md is made of docs/experiments.json, and that of the statements as they are now.

Whether the numbers are still what runs give, the system tests ask: each run of a statement is
compared there, the sweeps with every test (``exhaustive``).
"""

from __future__ import annotations

import json

import pytest

from cosim.base.errors import InputError
from cosim.thesis.claims.chapter_8 import STATEMENTS
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.claims.statement import runs_of
from cosim.thesis.expected.predictions import PREDICTIONS
from cosim.thesis.pages.docs import experiments_page
from cosim.thesis.results import Results
from cosim.thesis.sweeps.beyond import USERS, radii_of
from cosim.thesis.sweeps.breaking import CURVES, DELAYS, predict
from cosim.thesis.sweeps.free_motions import DELAYS as PREDICTED_DELAYS
from cosim.thesis.sweeps.free_motions import PREDICTORS, REALISM
from tests.support.experiments import NUMBERS, PAGE


@pytest.fixture(scope="module")
def results() -> Results:
    return Results.read(NUMBERS)


def test_the_page_is_written_from_its_numbers(results):
    assert PAGE.read_text(encoding="utf-8") == experiments_page(results)
    assert NUMBERS.read_text(encoding="utf-8") == results.text()


def test_another_number_is_another_page(results, tmp_path):
    plain = json.loads(NUMBERS.read_text(encoding="utf-8"))
    plain["runs"]["free_motion"]["expectations"][0]["measured"] *= 1.001
    plain["sweeps"]["realism"]["as built"]["ripple"] *= 1.1
    (tmp_path / "other.json").write_text(json.dumps(plain), encoding="utf-8")
    lines = experiments_page(Results.read(tmp_path / "other.json")).splitlines()
    changed = set(lines) - set(experiments_page(results).splitlines())
    assert len(changed) >= 3


def test_its_runs_are_those_of_the_statements_with_their_limits(results):
    wanted = runs_of((*STATEMENTS, *EXTENSIONS))
    said = {name: (run["file"], tuple(run["sets"])) for name, run in results.runs.items()}
    assert said == wanted
    for name, run in results.runs.items():
        for one in run["expectations"]:
            prediction = PREDICTIONS.get((run["file"].rpartition("/")[2], one["label"]))
            if prediction is None:
                continue  # what the scenario expects beside the statement
            limits = {(each.target, each.predicate): each.bounds() for each in prediction.limits}
            threshold = one["threshold"]
            found = tuple(threshold if isinstance(threshold, list) else [threshold])
            assert found == pytest.approx(limits[one["target"], one["predicate"]], rel=0.005), name


def test_every_statement_is_agreed_with_and_every_ablation_fails(results):
    for item in (*results.decided(STATEMENTS), *results.decided(EXTENSIONS)):
        if item.statement.undecidable:
            assert item.verdict == "cannot be decided"
            continue
        assert item.verdict == "agree", item.statement.name
        assert all(ablated.passed is False for ablated in item.ablated)


def test_its_sweeps_are_those_that_are_made(results):
    found = results.sweeps
    points = {curve: tuple(one.delay for one in row) for curve, row in found.limits.items()}
    assert points == {curve: DELAYS[curve] for curve in CURVES}
    assert tuple(found.realism) == tuple(REALISM)
    wanted = {(name, delay) for name in PREDICTORS for delay in PREDICTED_DELAYS}
    assert set(found.predictors) == wanted
    assert tuple(found.radii) == USERS


def test_what_theory_says_there_is_what_it_says_now(results):
    assert results.sweeps.radii[3] == pytest.approx(radii_of(3), rel=1e-5)
    stiffest = results.sweeps.limits["stiffness"]
    assert stiffest[1].predicted == pytest.approx(predict("stiffness", 1), rel=1e-5)


def test_another_file_is_refused(tmp_path):
    (tmp_path / "no.json").write_text('{"runs": {}}')
    for name in ("no.json", "none.json"):
        with pytest.raises(InputError, match="has no results of 'cohaptic thesis'"):
            Results.read(tmp_path / name)
