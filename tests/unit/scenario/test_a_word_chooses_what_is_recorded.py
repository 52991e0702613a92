"""``record: [summary]`` and ``[display]`` record what measures and pictures need, no more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.reading import load
from cosim.record.memory import extremes_of, run_in_memory
from cosim.report.judged import judge
from cosim.report.verdict.reading import parse_expectations
from cosim.scene import describe_scene
from tests.support.master.master_support import scenario_of

SHORT = ["duration=1.75 s"]


def judged(sets: Sequence[str]) -> tuple[dict[str, float], list[str], set[str]]:
    """Measures, verdicts and recorded names."""
    scenario = load("two_users_box", sets=[*SHORT, *sets])
    sink = MemorySink()
    with assemble(scenario) as simulation:
        outcome = simulation.run(sink)
    run = run_in_memory(sink, {"exit": {"ticks": outcome.ticks}})
    found = judge(run, parse_expectations(scenario, run.record_groups), extremes_of(sink))
    return found.measures, [str(verdict) for verdict in found.verdicts], set(run.signals)


def test_the_summary_of_what_a_summary_needs_is_that_of_everything() -> None:
    measures, verdicts, every = judged([])
    few = judged(["record=[summary]"])
    assert measures["grip_force"] > 0
    assert few[:2] == (measures, verdicts)
    assert len(few[2]) < len(every) / 4


@pytest.mark.parametrize("name", ["two_users_box", "single_axis_distributed"])
def test_what_is_drawn_of_the_display_is_what_is_drawn_of_everything(name: str) -> None:
    scenes = []
    for sets in ([], ["record=[display]"]):
        with assemble(load(name, sets=sets)) as simulation:
            scenes.append(describe_scene(simulation.assembly, simulation.groups))
    assert scenes[0] == scenes[1]
    assert scenes[0]["boxes"] or scenes[0]["bodies"]


def written(**more: object) -> dict[str, object]:
    parts = {"push": {"fmu": "signal", "rate": 1024, "station": "a"}}
    return {"duration": "1/16", "components": parts, "record": ["summary"], **more}


def test_what_expectations_name_is_recorded(tmp_path: Path) -> None:
    expect = {"push.value - push.rate": {"max_below": 2}}
    with assemble(scenario_of(tmp_path, written(expect=expect))) as simulation:
        names = [column.name for group in simulation.groups for column in group.columns]
    assert names == ["push.value", "push.rate"]


def test_a_word_that_stands_for_nothing_is_refused_at_its_place(tmp_path: Path) -> None:
    with (
        pytest.raises(InputError, match=r":1:121: 'summary' stands for what measures"),
        assemble(scenario_of(tmp_path, written())),
    ):
        pass
