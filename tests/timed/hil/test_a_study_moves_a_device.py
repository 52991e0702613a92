"""A study's trials keep pace with the clock, with a device in the scenario."""

from __future__ import annotations

import json
from pathlib import Path

from cosim.record.reader import open_run
from tests.support.terminal import Terminal

SCENARIO = """\
cohaptic: 1
include: [devices/mock, two_users_box]
duration: 0.5
expect: ~
"""
PLAN = """\
study: 1
scenario: held.yaml
conditions: {light: {set: [components.vr_a.parameters.mass=0.3]}, heavy: {}}
trials: 1
questions: {held: {ask: "Did you hold it?"}}
"""


def test_trials_are_paced_and_recorded(tmp_path: Path) -> None:
    (tmp_path / "held.yaml").write_text(SCENARIO)
    (tmp_path / "plan.yaml").write_text(PLAN)
    sitting = Terminal(tmp_path, "study", "plan.yaml", "--participant", "P1")
    for trial in (1, 2):
        sitting.listen_for(f"Trial {trial} of 2.")
        sitting.listen_for("Did you hold it? (y/n): ")
        sitting.type("y\n")
    assert sitting.process.wait(20) == 0
    person = tmp_path / "studies" / "plan" / "people" / "P1"
    masses = []
    for trial in (1, 2):
        folder = person / f"trial-00{trial}"
        summary = json.loads((folder / "summary.json").read_text())
        assert summary["wall_time"] > 0.49, "it is not run as fast as it goes"
        assert summary["deadlines"]
        with open_run(folder) as run:
            assert any(name.startswith("finger_a1.") for name in run.signals)
            masses.append("mass: 0.3" in run.scenario_yaml)
    assert masses == [True, False]
