"""A run that starts late: FMUs, events, expectations and the record agree on its time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

import fmus
from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from cosim.record import open_run
from cosim.run import run_scenario
from cosim.scenario import Scenario, load
from cosim.scenario.resolved import to_yaml
from tests.support.master.master_support import run, scenario_of

RATE, START, SECONDS = 1024, 10, 0.25
SINE = {"mode": "sine", "frequency": 40.0, "amplitude": 2.0, "start_time": 10.1}


def sine(folder: Path, flavour: str = "fmi3", **more: Any) -> Scenario:
    component = {"fmu": "signal", "flavour": flavour, "rate": RATE, "parameters": SINE}
    return scenario_of(
        folder,
        {"start_time": START, "duration": SECONDS, "components": {"s": component}, **more},
    )


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
@pytest.mark.parametrize("substeps", [1, 4])
def test_an_fmu_is_told_as_fmpy_tells_it(flavour: str, substeps: int, tmp_path: Path) -> None:
    scenario = sine(tmp_path, flavour)
    known = fmpy.simulate_fmu(
        str(fmus.find("signal", flavour)),
        start_values={**SINE, "mode": 2},
        start_time=START,
        stop_time=START + SECONDS,
        output_interval=1 / RATE,
        output=["value"],
        fmi_type="CoSimulation",
    )
    written = to_yaml(scenario).replace("substeps: 1", f"substeps: {substeps}")
    (tmp_path / "again.yaml").write_text(written)
    again = load(tmp_path / "again.yaml")
    assert again.start_tick == START * RATE
    sink, _ = run(again)
    np.testing.assert_array_equal(sink.signal("s.value"), known["value"][:-1])
    assert np.ptp(sink.signal("s.value")) > 2.0


def test_events_and_expectations_are_at_times_since_0(tmp_path: Path) -> None:
    scenario = sine(
        tmp_path,
        events=[
            {"at": "10.125 s", "set": {"s.offset": 100}},
            {"at": "200 ticks", "set": {"s.offset": 0}},
        ],
        expect={"s.offset": {"from": 10.125, "to": 10.19, "min_above": 99}},
    )
    finished = run_scenario(scenario, tmp_path / "run", figure=True)
    assert finished.summary.content["status"] == 0, finished.summary.content
    with open_run(finished.folder) as record:
        group = record["s.offset"].group
        assert group.time[0] == START
        turned = group.time[np.flatnonzero(np.diff(record["s.offset"].values)) + 1]
        assert turned.tolist() == [10.125, 10 + 200 / RATE]
        assert record.span == (START, START + SECONDS)


def test_a_snapshot_goes_on_at_its_time(tmp_path: Path) -> None:
    scenario = sine(tmp_path)
    whole, _ = run(scenario)
    with assemble(scenario) as first:
        first.start()
        first.advance(150)
        snapshot = first.snapshot()
        with assemble(scenario) as second:
            second.restore(snapshot)
            second.start()
            second.advance(200)
            assert second.program.view("s", "value")[0] == whole.signal("s.value")[199]
    other = scenario_of(
        tmp_path,
        {
            "duration": SECONDS,
            "components": {"s": {"fmu": "signal", "rate": RATE, "parameters": SINE}},
        },
    )
    with assemble(other) as simulation, pytest.raises(InputError, match="another plan"):
        simulation.restore(snapshot)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"start_time": 10.0001}, "10.0001 s lies between two base ticks; write 10 s or 10.000976"),
        ({"start_time": -1}, "-1 is out of range: at least 0 s"),
        (
            {"events": [{"at": 9.9, "set": {"s.offset": 1}}]},
            "events.0: it lies before the run, which starts at 10 s",
        ),
        (
            {"events": [{"at": 10.25, "set": {"s.offset": 1}}]},
            "it is at tick 256, and the run ends before that",
        ),
    ],
)
def test_what_lies_outside_is_refused(more: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        sine(tmp_path, **more)
    assert sentence in str(refused.value)
