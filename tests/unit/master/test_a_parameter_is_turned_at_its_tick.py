"""A tunable parameter is turned at exactly its tick, as FMPy's own loop does it, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import yaml

import fmus
from cosim.base.component import Causality, Cells, Component, Setup, Variable
from cosim.base.errors import RunError
from cosim.base.recording import MemorySink
from cosim.master.assembly.variation import with_values
from cosim.master.run.simulation import assemble
from cosim.scenario import Scenario
from tests.support.master.master_support import run, scenario_of

RATE, TICKS = 1024, 256
WALL = {"mass": 0.5, "wall_stiffness": 50.0, "wall_position": 0.1, "initial_position": 0.0}
TURNS = [(40, "wall_stiffness", 400.0), (41, "wall_damping", 3.0), (200, "wall_stiffness", 0.0)]


def wall(flavour: str, events: Sequence[Any] = (), **more: Any) -> dict[str, Any]:
    return {
        "duration": TICKS / RATE,
        "components": {
            "object": {"fmu": "object", "flavour": flavour, "rate": RATE, "parameters": WALL}
        },
        "events": list(events),
        **more,
    }


def events_of(turns: Sequence[tuple[int, str, float]]) -> list[Any]:
    return [
        {"at": f"{tick} ticks", "set": {f"object.{name}": value}} for tick, name, value in turns
    ]


def by_fmpy(flavour: str) -> Any:
    """The same turns in FMPy's loop, whose input table has a row before and after each."""
    names = sorted({name for _, name, _ in TURNS})
    standing = {name: float(WALL.get(name, 0.0)) for name in names}
    rows = [(0.0, *standing.values())]
    for tick, name, value in TURNS:
        rows.append((tick / RATE, *standing.values()))
        standing[name] = value
        rows.append((tick / RATE, *standing.values()))
    table = np.array(rows, dtype=[("time", float), *((name, float) for name in names)])
    return fmpy.simulate_fmu(
        str(fmus.find("object", flavour)),
        start_values=WALL,
        input=table,
        stop_time=TICKS / RATE,
        output_interval=1 / RATE,
        output=["position", "velocity"],
        fmi_type="CoSimulation",
    )


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_an_event_is_what_fmpy_does(flavour: str, tmp_path: Path) -> None:
    sink, _ = run(scenario_of(tmp_path, wall(flavour, events_of(TURNS))))
    known = by_fmpy(flavour)
    for name in ("position", "velocity"):
        np.testing.assert_array_equal(sink.signal(f"object.{name}"), known[name][:-1])
    stiffness = sink.signal("object.wall_stiffness")
    assert [stiffness[tick] for tick in (39, 40, 199, 200)] == [50.0, 400.0, 400.0, 0.0]


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_outputs_of_the_same_tick_follow(flavour: str, tmp_path: Path) -> None:
    """The force of a coupler is that of the new stiffness at the tick of the event."""
    scenario = scenario_of(
        tmp_path,
        {
            "duration": 20 / RATE,
            "components": {
                "coupler": {
                    "fmu": "virtual_coupler",
                    "flavour": flavour,
                    "rate": RATE,
                    "parameters": {"stiffness": 100.0},
                    "start": {"position_a": 0.5},
                }
            },
            "events": [{"at": "7 ticks", "set": {"coupler.stiffness": "0.3 kN/m"}}],
        },
    )
    sink, _ = run(scenario)
    expected = np.where(np.arange(20) < 7, 50.0, 150.0)
    np.testing.assert_array_equal(sink.signal("coupler.force"), expected)


def test_a_connection_turns_as_events_do(tmp_path: Path) -> None:
    """Between two components inside a tick a wired knob is an input on which all outputs depend."""
    coupler = {
        "fmu": "virtual_coupler", "rate": RATE, "start": {"position_a": 0.5},
        "parameters": {"stiffness": 100.0},
    }  # fmt: skip
    knob = {
        "fmu": "signal", "rate": RATE,
        "parameters": {"mode": "step", "start_time": 7 / RATE, "offset": 100, "amplitude": 200},
    }  # fmt: skip
    scenario = scenario_of(
        tmp_path,
        {
            "duration": 20 / RATE,
            "components": {"coupler": coupler, "knob": knob},
            "connections": ["knob.value -> coupler.stiffness"],
        },
    )
    sink, _ = run(scenario)
    expected = np.where(np.arange(20) < 7, 50.0, 150.0)
    np.testing.assert_array_equal(sink.signal("coupler.force"), expected)
    np.testing.assert_array_equal(sink.signal("coupler.stiffness"), 2 * expected)


def test_a_slower_component_takes_it_at_its_next_step(tmp_path: Path) -> None:
    written = wall("fmi3", events_of([(41, "wall_stiffness", 400.0)]))
    written["components"]["object"]["rate"] = RATE / 8
    written["base_rate"] = RATE
    sink, _ = run(scenario_of(tmp_path, written))
    assert sink.signal("object.wall_stiffness")[[5, 6]].tolist() == [50.0, 400.0]


class Scaled(Component):
    """Puts out its tunable parameter, as it is at each tick."""

    @property
    def variables(self) -> Sequence[Variable]:
        tunable = {"causality": Causality.PARAMETER, "variability": "tunable"}
        return [
            Variable(name="gain", start=2.0, maximum=9.0, unit="1", **tunable),
            Variable(name="value", causality=Causality.OUTPUT, unit="1"),
        ]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        self.value = outputs["value"]
        self.gain = inputs.get("gain", np.array([setup.parameters["gain"]]))

    def evaluate(self, tick: int) -> None:
        self.value[0] = self.gain[0]


def scaled(folder: Path, **more: Any) -> Scenario:
    python = {"python": f"{__name__}:Scaled", "rate": RATE}
    return scenario_of(folder, {"duration": 10 / RATE, "components": {"a": python}, **more})


def test_a_python_component_finds_what_is_turned_among_its_inputs(tmp_path: Path) -> None:
    sink, _ = run(scaled(tmp_path, events=[{"at": "3 ticks", "set": {"a.gain": 5}}]))
    assert sink.signal("a.value").tolist() == [2.0] * 3 + [5.0] * 7
    assert run(scaled(tmp_path))[0].signal("a.value").tolist() == [2.0] * 10


def test_a_connection_that_goes_too_far_ends_the_run_with_a_sentence(tmp_path: Path) -> None:
    knob = {"fmu": "signal", "rate": RATE, "parameters": {
        "mode": "step", "start_time": 4 / RATE, "amplitude": 20}}  # fmt: skip
    python = {"python": f"{__name__}:Scaled", "rate": RATE}
    written = {
        "duration": 10 / RATE,
        "components": {"a": python, "knob": knob},
        "connections": ["knob.value -> a.gain"],
    }
    with pytest.raises(RunError, match=r"a.gain was turned to 20 by knob.value -> a.gain at tick 4 "
                       r".*: it goes from -inf to 9"):  # fmt: skip
        run(scenario_of(tmp_path, written))


def turned_by_hand(scenario: Scenario, turns: Mapping[int, Mapping[str, Any]]) -> Any:
    sink = MemorySink()
    with assemble(scenario) as simulation:
        pauses = {
            tick: lambda values=values: simulation.set(values) for tick, values in turns.items()
        }
        simulation.run(sink, pauses=pauses)
        return sink, simulation.replay()


def test_what_is_set_by_hand_is_an_event_of_the_replay(tmp_path: Path) -> None:
    from cosim.scenario.resolved import to_yaml

    scenario = scenario_of(
        tmp_path,
        wall(
            "fmi3",
            events_of([(20, "wall_damping", 1.0)]),
            knobs={"object.wall_stiffness": {"minimum": 0, "maximum": "1 N/mm"}},
        ),
    )
    turns = {7: {"object.wall_stiffness": "0.2 N/mm"}, 20: {"object.wall_damping": 5}}
    turns[99] = {"object.wall_stiffness": 123.456789, "object.wall_damping": 0.1}
    sink, replay = turned_by_hand(scenario, turns)
    assert sink.signal("object.wall_stiffness")[[6, 7, 98, 99]].tolist() == [
        50.0, 200.0, 200.0, 123.456789,
    ]  # fmt: skip
    assert sink.signal("object.wall_damping")[20] == 1.0, (
        "an event comes after what is done by hand"
    )
    again = tmp_path / "again.yaml"
    again.write_text(to_yaml(replay))
    written = yaml.safe_load(again.read_text())["events"]
    assert [event["at"] for event in written] == ["7 ticks", "20 ticks", "99 ticks"]
    from cosim.scenario import load

    repeated, _ = run(load(again))
    for name in ("position", "velocity", "wall_stiffness", "wall_damping"):
        np.testing.assert_array_equal(
            sink.signal(f"object.{name}"), repeated.signal(f"object.{name}")
        )


FILE = {"fmu": str(fmus.find("object", "fmi3")), "feedthrough": True}
"""The same FMU as if it were somebody else's, whose library is another one in each run."""


@pytest.mark.parametrize("how", [{}, FILE, {**FILE, "isolate": "process"}])
def test_a_simulation_is_renewed_with_other_events(tmp_path: Path, how: dict[str, Any]) -> None:
    """Nothing of the run before is left, neither what it turned nor where its knobs stood."""
    scenarios: list[Scenario] = []
    for tick, stiffness in ((40, 400.0), (99, 10.0), (7, 0.0)):
        written = wall("fmi3", events_of([(tick, "wall_stiffness", stiffness)]))
        written["components"]["object"] |= how
        if how:
            del written["components"]["object"]["flavour"]
        scenarios.append(scenario_of(tmp_path, written))
    first = assemble(scenarios[0])
    with first:
        for scenario in scenarios:
            assembly = with_values(first.assembly, scenario)
            assert assembly is not None
            first.renew(assembly)
            sink = MemorySink()
            first.run(sink, keep_fmus=True)
            fresh, _ = run(scenario)
            for name in ("position", "wall_stiffness"):
                np.testing.assert_array_equal(
                    sink.signal(f"object.{name}"), fresh.signal(f"object.{name}")
                )
    more = wall("fmi3", events_of([(3, "wall_damping", 1.0)]))
    assert with_values(first.assembly, scenario_of(tmp_path, more)) is None


def test_a_tunable_parameter_that_stays_can_be_recorded_by_its_name(tmp_path: Path) -> None:
    """So events can be taken out of a scenario that records what they turn."""
    written = wall("fmi3", record=["object.wall_stiffness", "object.position"])
    sink, _ = run(scenario_of(tmp_path, written))
    assert set(sink.signal("object.wall_stiffness").tolist()) == {50.0}
    plain, _ = run(scenario_of(tmp_path, wall("fmi3")))
    np.testing.assert_array_equal(sink.signal("object.position"), plain.signal("object.position"))
    assert "object.wall_stiffness" not in [c.name for g in plain.groups for c in g.columns]
