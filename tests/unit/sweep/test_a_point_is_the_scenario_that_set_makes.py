"""What a point's values make of a scenario is what ``--set`` makes of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.reading import FORMS, load
from cosim.sweep.planning.plan import Request, plan_of, read_plan
from cosim.sweep.work.variants import Variants
from tests.support.sweep.parts import SCENARIO


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sweep") / "test.yaml"
    path.write_text(json.dumps(SCENARIO))
    return path


def two(values: st.SearchStrategy[Any]) -> st.SearchStrategy[list[Any]]:
    return st.lists(values, min_size=2, max_size=2)


PLACES = {
    "seed": two(st.integers(0, 100)),
    "components.push.parameters.amplitude": two(st.floats(0.1, 2.0) | st.integers(1, 3)),
    "components.hand.parameters.mass": two(st.sampled_from([0.1, 1, "0x1"]))
    | two(st.sampled_from(["200 g", "0.5 g"])),
    "components.hand.parameters.initial_velocity": two(st.floats(-1, 1)),
    "channels.lan.loss": two(st.floats(0, 1)),
    "channels.lan.round_trip_delay": two(st.integers(0, 5)),
    "duration": st.sampled_from([[0.01, 0.02], ["30 ms", "10 ms"]]),
}


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_every_way_gives_the_same(scenario: Path, data: st.DataObject) -> None:
    chosen = data.draw(st.lists(st.sampled_from(sorted(PLACES)), min_size=1, unique=True))
    vary = {place: data.draw(PLACES[place]) for place in chosen}
    plan = plan_of(Request(scenario=scenario, vary=vary), FORMS)
    variants = Variants(plan.job)
    middle = len(plan.points) // 2
    for point in {plan.points[0], plan.points[middle], plan.points[-1]}:
        found = variants.scenario(point)
        expected = load(scenario, sets=plan.job.overrides(point))
        for name in ("seed", "components", "channels", "duration", "ticks", "connections"):
            assert getattr(found, name) == getattr(expected, name)


@pytest.mark.parametrize(
    ("place", "paths"),
    [
        ("hand.mass", ["components.hand.parameters.mass"]),
        ("lan.loss", ["channels.lan.loss"]),
        ("hand.rate", ["components.hand.rate"]),
        (
            "*a*.mass",  # hand and part; the channel lan can have none
            ["components.hand.parameters.mass", "components.part.parameters.mass"],
        ),
        ("components.p*.rate", ["components.push.rate", "components.part.rate"]),
        ("lan.mass", ["channels.lan.mass"]),  # refused when it is read
        ("la*.loss", ["channels.lan.loss"]),
        ("duration", ["duration"]),
    ],
)
def test_a_short_name_stands_for_paths(scenario: Path, place: str, paths: list[str]) -> None:
    plan = plan_of(Request(scenario=scenario, vary={place: [1, 2]}), FORMS)
    assert list(plan.axes[0].places) == paths


def test_an_anchor_stands_for_its_aliases() -> None:
    plan = plan_of(
        Request(scenario="single_axis_distributed", vary={"x-constants.local.stiffness": [1, 2]}),
        FORMS,
    )
    assert plan.axes[0].places == (
        "components.coupler_11.parameters.stiffness",
        "components.coupler_22.parameters.stiffness",
    )


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        ({"vary": {"hnd.mass": [1]}}, "Did you mean hand"),
        ({"vary": {"x-nothing.a": [1]}}, "used nowhere"),
        ({"vary": {}}, "nothing is varied"),
        ({"vary": {"seed": [1]}, "seeds": 2}, "varied already"),
        ({"vary": {"a": {"set": "lan.loss", "values": [0]}, "lan.loss": [0]}}, "by a and by lan"),
        ({"vary": {"lan.loss": [0, 1]}, "boundary": True}, "grid of two variables"),
        ({"vary": {"lan.loss": {"value": [1]}}}, "write its 'values'"),
        ({"vary": {"lan.loss": [0]}, "measure": {"hand.position": "rsm"}}, "Did you mean rms"),
        ({"vary": {"lan.loss": [0]}, "points": 5}, "a grid has the points"),
        ({"vary": {"lan.loss": [0, 1]}, "sample": "sobol", "points": 8}, "that is a range"),
        ({"vary": {"lan.loss": [0]}, "sample": "sobl"}, "Did you mean sobol"),
        ({"vary": {"lan.loss": [0]}, "sample_seed": 3}, "a grid draws nothing"),
        ({"vary": {}, "seeds": 0}, "0 seeds are none"),
        ({"vary": {"lan.loss": 0.5}}, "write a list of values or a range"),
        ({"vary": {"lan.loss": [None]}}, "is no value"),
        ({"vary": {"lan.loss": []}}, "has no values"),
        ({"vary": {"lan.loss": "0..1/1"}}, "one point is not both ends"),
        ({"vary": {"lan.loss": "0..1/1001", "hand.mass": "1..2/1000"}}, "1001000 points; a sweep"),
        (
            {"vary": {"lan.loss": "0..1/2"}, "sample": "sobol", "points": 2**30},
            "1073741824 points; a sweep has at most 1000000",
        ),
        ({"vary": {"hand.mass": "1 kg, 200 g"}}, "in one unit, not g and kg"),
        ({"vary": {"z*.mass": [1]}}, "nothing in the scenario fits"),
        ({"vary": {"l*.mass": [1]}}, "is no place in the scenario"),
    ],
)
def test_what_cannot_be_planned(scenario: Path, request_: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        plan_of(Request(scenario=scenario, **request_), FORMS)


def test_arrays_of_numbers_are_values_and_lists_are_written_as_yaml(scenario: Path) -> None:
    vary = {
        "lan.loss": np.linspace(0, 0.5, 3),
        "lan.round_trip_delay": np.arange(2),
        "hand.initial_velocity": [np.float64(0.25)],
        "push.via_times": [[1, 2], (3, 4.5)],
    }
    plan = plan_of(Request(scenario=scenario, vary=vary), FORMS)
    assert plan.points[-1] == (0.5, 1, 0.25, "[3, 4.5]")
    assert [type(value) for value in plan.points[-1]] == [float, int, float, str]
    assert plan.job.overrides(plan.points[-1])[:2] == [
        "channels.lan.loss=0.5",
        "channels.lan.round_trip_delay=1",
    ]


def test_a_plan_in_a_file(scenario: Path) -> None:
    file = scenario.parent / "plan.yaml"
    file.write_text(
        """
sweep: 1
scenario: test.yaml
set: [duration=10 ms]
vary:
  lan.loss: 0..0.5/3
  weight: {set: [hand.mass], values: 0.1..1/2 log}
seeds: 2
expect: {hand.velocity: {max_abs_below: 5}}
measure: {hand.position: [max, rms]}
check_every: 0
"""
    )
    plan = plan_of(read_plan(file), FORMS)
    assert len(plan.points) == 12
    assert plan.points[0] == (0.0, 0.1, 1)
    assert plan.expectations == {
        "hand.position": {"max_abs_below": 10},
        "hand.velocity": {"max_abs_below": 5},
    }
    assert plan.job.readings == (("hand.position", "max"), ("hand.position", "rms"))


def test_a_misspelt_key_of_a_plan_is_a_located_sentence(scenario: Path) -> None:
    file = scenario.parent / "bad.yaml"
    file.write_text("sweep: 1\nscenario: test.yaml\nvari: {seed: 1..3}\n")
    with pytest.raises(InputError, match=r"bad.yaml:3:1: .*vary"):
        read_plan(file)
