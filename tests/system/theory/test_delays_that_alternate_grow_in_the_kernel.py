"""Two delays that are stable each: in turns the run grows by what the theory's word says."""

from __future__ import annotations

import math

import pytest

from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.robust.joint_radius import joint_radius
from cosim.theory.robust.network import switching_delays
from cosim.thesis.experiments import run_one
from cosim.thesis.extensions import EXTENSIONS
from cosim.thesis.statements import ablation_runs, decide

NAME = "alternating_delays"
STATEMENT = [one for one in EXTENSIONS if one.name == "alternating-delays"]


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alternating")
    wanted = {NAME: (f"thesis/{NAME}", ()), **ablation_runs(STATEMENT)}
    return {
        name: run_one(name, file, sets, folder / name).summary
        for name, (file, sets) in wanted.items()
    }


def growth(summary) -> float:
    return next(entry["measured"] for entry in summary["expectations"])


def test_the_run_grows_as_the_joint_radius_says(summaries):
    model = Parameters("centralized", {}, TABLE_6_1["centralized"]).model()
    found = joint_radius(switching_delays(model, Timing(), (0, 1), (0, 1))[0])
    assert growth(summaries[NAME]) == pytest.approx(128 * math.log(found.lower), rel=0.02)


def test_either_delay_alone_decays(summaries):
    ablated = ablation_runs(STATEMENT)
    assert len(ablated) == 2
    assert all(growth(summaries[name]) < -0.4 for name in ablated)
    assert [item.verdict for item in decide(summaries, {}, STATEMENT)] == ["agree"]
