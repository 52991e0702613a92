"""Two delays that are stable each: in turns the run grows by what the theory's word says."""

from __future__ import annotations

import math

import pytest

from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.network import switching_delays
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.claims.statement import runs_of
from cosim.thesis.claims.verdict import decide
from cosim.thesis.experiments import run_one

NAME = "alternating_delays"
STATEMENT = [one for one in EXTENSIONS if one.name == "alternating-delays"]


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alternating")
    return {
        name: run_one(name, file, sets, folder / name).summary
        for name, (file, sets) in runs_of(STATEMENT).items()
    }


def growth(summary) -> float:
    return next(entry["measured"] for entry in summary["expectations"])


def test_the_run_grows_as_the_joint_radius_says(summaries):
    model = Parameters("centralized", {}, TABLE_6_1["centralized"]).model()
    found = joint_radius(switching_delays(model, Timing(), (0, 1), (0, 1))[0])
    assert growth(summaries[NAME]) == pytest.approx(128 * math.log(found.lower), rel=0.02)


def test_either_delay_alone_decays(summaries):
    ablated = [name for name in runs_of(STATEMENT) if name != NAME]
    assert len(ablated) == 2
    assert all(growth(summaries[name]) < -0.4 for name in ablated)
    assert [item.verdict for item in decide(summaries, {}, STATEMENT)] == ["agree"]
