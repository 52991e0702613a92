"""One assembly serves any number of runs, each of which computes what a first run would."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.base.component import Component
from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.assembly.variation import with_values
from cosim.master.run.fingerprint import components_of, plan_digest
from cosim.master.run.simulation import Simulation, assemble
from cosim.reading import load
from tests.support.master.master_parts import Growing
from tests.support.master.master_support import scenario_of

PARTS = "tests.support.master.resumable_parts"
BURSTS = {"good_to_bad": 0.1, "bad_to_good": 0.3}

WRITTEN: dict[str, Any] = {
    "duration": 90 / 1024,
    "seed": 3,
    "components": {
        "push": {
            "fmu": "signal",
            "rate": 1024,
            "station": "a",
            "parameters": {"mode": "sine", "frequency": 20.0},
        },
        "hand": {"fmu": "hand", "rate": 1024, "station": "b", "parameters": {"mass": 0.2}},
        "count": {"python": f"{PARTS}:Counting", "rate": 1024, "station": "a"},
    },
    "channels": {
        "lan": {
            "between": ["a", "b"],
            "rate": 128,
            "round_trip_delay": 2,
            "loss": BURSTS,
            "jitter": 1,
        }
    },
    "connections": ["push.value -> hand.force via lan"],
    "record": ["*"],
}


def rows(simulation: Simulation) -> list[Any]:
    sink = MemorySink()
    simulation.run(sink, keep_fmus=True)
    return [sink.rows(group) for group in range(len(sink.groups))]


def first_run(folder: Path, sets: Sequence[str] = ()) -> list[Any]:
    with assemble(scenario_of(folder, WRITTEN, sets)) as simulation:
        return rows(simulation)


def equal(one: list[Any], other: list[Any]) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def test_two_runs_of_one_assembly_draw_the_same_packets(tmp_path: Path) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as first:
        expected = rows(first)
        before = plan_digest(first.assembly), components_of(first.assembly)
        with Simulation(first.assembly) as second:
            assert equal(rows(second), expected)
        assert (plan_digest(first.assembly), components_of(first.assembly)) == before


def test_two_runs_at_a_time_share_no_component(tmp_path: Path) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as first, Simulation(first.assembly) as second:
        for each in (first, second):
            each.start()
        first.advance(40)
        second.advance(20)
        first.advance(60)
        second.advance(60)
        np.testing.assert_array_equal(first.program.cells, second.program.cells)


def test_a_renewed_simulation_runs_as_a_new_one(tmp_path: Path) -> None:
    expected = first_run(tmp_path)
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        for _ in range(3):
            assert equal(rows(simulation), expected)
            simulation.renew(simulation.assembly)


def test_a_component_that_was_handed_in_serves_once(tmp_path: Path) -> None:
    written = {**WRITTEN, "components": {**WRITTEN["components"]}}
    given: dict[str, Component] = {"count": Growing()}
    with assemble(scenario_of(tmp_path, written), given) as simulation:
        rows(simulation)
        simulation.renew(simulation.assembly)
        with pytest.raises(InputError, match="exists only once and has served a run"):
            rows(simulation)


VALUES = st.fixed_dictionaries(
    {},
    optional={
        "seed": st.integers(0, 1000),
        "components.push.parameters.amplitude": st.floats(0.1, 5.0),
        "components.hand.parameters.mass": st.floats(0.05, 2.0),
        "components.hand.parameters.initial_position": st.floats(-0.1, 0.1),
        "channels.lan.loss": st.floats(0.0, 0.9),
        "channels.lan.jitter": st.integers(0, 2),
        "channels.lan.round_trip_delay": st.integers(2, 9),
        "duration": st.sampled_from([0.02, 0.05, 0.1]),
    },
)


@settings(
    deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(VALUES, VALUES)
def test_other_values_give_what_a_first_run_gives(
    tmp_path: Path, first: dict[str, Any], second: dict[str, Any]
) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        base = simulation.assembly
        for values in (first, second):
            sets = [f"{path}={value}" for path, value in values.items()]
            scenario = scenario_of(tmp_path, WRITTEN, sets)
            assembly = with_values(base, scenario)
            if assembly is None:
                with assemble(scenario) as other:
                    assert other.assembly.wiring.bundles[0].can_be_immediate
                continue
            assert assembly.scenario.components == scenario.components
            simulation.renew(assembly)
            assert equal(rows(simulation), first_run(tmp_path, sets))


@pytest.mark.parametrize(
    "change",
    [
        "channels.lan.round_trip_delay=0",
        "channels.lan.rate=256",
        "components.hand.rate=512",
        "components.hand.fmu=object",
        "components.hand.flavour=fmi2",
        "record=[hand.position]",
        "components.count.python=tests.support.master.master_parts:Growing",
        "base_rate=2048",
    ],
)
def test_what_may_change_the_plan_is_another_assembly(tmp_path: Path, change: str) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        assert with_values(simulation.assembly, scenario_of(tmp_path, WRITTEN, [change])) is None


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("components.hand.parameters.mas=1", "Did you mean mass?"),
        ("components.hand.parameters.mass=-1", "the least that it can be"),
    ],
)
def test_a_bad_value_is_a_sentence_with_its_place(
    tmp_path: Path, change: str, sentence: str
) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        scenario = scenario_of(tmp_path, WRITTEN, [change])
        with pytest.raises(InputError) as found:
            with_values(simulation.assembly, scenario)
        with pytest.raises(InputError) as expected, assemble(scenario):
            pass
    assert sentence in str(found.value)
    assert str(found.value) == str(expected.value)


def test_an_assembly_of_another_plan_does_not_fit(tmp_path: Path) -> None:
    other = scenario_of(tmp_path, WRITTEN, ["channels.lan.round_trip_delay=0"])
    with (
        assemble(scenario_of(tmp_path, WRITTEN)) as simulation,
        assemble(other) as another,
        pytest.raises(InputError, match="of the same plan"),
    ):
        simulation.renew(another.assembly)


def test_a_simulation_is_recorded_always_or_never(tmp_path: Path) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        rows(simulation)
        simulation.renew(simulation.assembly)
        with pytest.raises(RunError, match="either recorded in all of its runs"):
            simulation.run(keep_fmus=True)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_the_bundled_box_in_every_flavour(flavour: str) -> None:
    sets = ["duration=0.2", "channels.lan.loss=0.1"]
    sets += [
        f"components.{name}.flavour={flavour}"
        for name in ("finger_a1", "finger_a2", "vr_a", "operator_a1")
    ]
    changed = [*sets, "seed=11", "components.vr_a.parameters.mass=0.5"]
    with assemble(load("two_users_box", sets=changed)) as simulation:
        expected = rows(simulation)
    with assemble(load("two_users_box", sets=sets)) as simulation:
        base = rows(simulation)
        assembly = with_values(simulation.assembly, load("two_users_box", sets=changed))
        assert assembly is not None
        simulation.renew(assembly)
        assert equal(rows(simulation), expected)
        simulation.renew(simulation.assembly)
        assert not equal(base, expected)


def test_a_further_run_calls_no_fmu_from_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        noted: list[str] = []
        monkeypatch.setattr(simulation.whereabouts, "note", lambda *what: noted.append(what[0]))
        rows(simulation)
        assert {"push", "hand", "count"} <= set(noted)
        noted.clear()
        lighter = scenario_of(tmp_path, WRITTEN, ["components.hand.parameters.mass=0.1"])
        assembly = with_values(simulation.assembly, lighter)
        assert assembly is not None
        simulation.renew(assembly)
        rows(simulation)
        assert set(noted) == {"count"}  # a component in Python


def test_what_an_fmu_refuses_in_a_further_run_is_the_same_sentence(tmp_path: Path) -> None:
    refused = ["components.push.parameters.mode=minimum_jerk"]
    with (
        assemble(scenario_of(tmp_path, WRITTEN, refused)) as simulation,
        pytest.raises(InputError, match="duration is 0 s") as expected,
    ):
        rows(simulation)
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        base = simulation.assembly
        good = rows(simulation)
        assembly = with_values(base, scenario_of(tmp_path, WRITTEN, refused))
        assert assembly is not None
        simulation.renew(assembly)
        with pytest.raises(InputError) as found:
            rows(simulation)
        assert str(found.value) == str(expected.value)
        simulation.renew(base)
        assert equal(rows(simulation), good)


def test_after_an_error_the_next_run_is_a_good_one(tmp_path: Path) -> None:
    expected = first_run(tmp_path)
    with assemble(scenario_of(tmp_path, WRITTEN)) as simulation:
        base = simulation.assembly
        wild = scenario_of(
            tmp_path,
            WRITTEN,
            [
                "components.push.parameters.amplitude=1e308",
                "components.push.parameters.offset=1e308",
            ],
        )
        assembly = with_values(base, wild)
        assert assembly is not None
        simulation.renew(assembly)
        with pytest.raises(RunError):
            simulation.run(MemorySink(), keep_fmus=True)
        simulation.renew(base)
        assert equal(rows(simulation), expected)
