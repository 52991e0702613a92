"""Ctrl-C, playback of an earlier run, and a component that is given: the record stays right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.record.playback import KINDS
from cosim.record.writer import Recorder
from tests.support.master.master_parts import Growing
from tests.support.master.master_support import run, scenario_of
from tests.support.master.single_axis import GAINS, single_axis


def test_ctrl_c_ends_the_run_between_two_ticks_and_keeps_the_rows(tmp_path: Path) -> None:
    written = {
        "duration": 10,
        "components": {
            "mine": {"python": "tests.support.master.master_parts:PressesCtrlC", "rate": 1024},
            "hand": {"fmu": "hand", "rate": 512, "start": {"force": 1.0}},
        },
    }
    sink = MemorySink()
    simulation = assemble(scenario_of(tmp_path, written))
    outcome = simulation.run(sink)
    assert outcome.interrupted
    assert 300 < outcome.ticks < 300 + 1025
    assert len(sink.signal("mine.value")) == outcome.ticks
    assert len(sink.signal("hand.position")) == -(-outcome.ticks // 2)


def test_a_played_back_component_leads_to_the_same_run(tmp_path: Path) -> None:
    gains, channel = GAINS["distributed"]["soft"], {"round_trip_delay": 2, "loss": 0.1}
    scenario = single_axis(tmp_path, "distributed", gains, channel)
    folder = tmp_path / "earlier"
    folder.mkdir()
    expected, _ = run(scenario)
    recorder = Recorder(folder / "run.h5", scenario.ticks)
    assemble(scenario).run(recorder)
    recorder.close()

    more = {"components": {"hand_2": {"playback": str(folder)}}}
    replayed = single_axis(tmp_path, "distributed", gains, channel, more=more)
    with pytest.raises(InputError, match="hand_2 is a playback, which nobody here can run"):
        assemble(replayed)
    actual = MemorySink()
    with assemble(replayed, kinds=KINDS) as simulation:
        simulation.run(actual)
    for name in ("hand_2.position", "object_2.position", "hand_1.velocity", "coupler_12.force"):
        np.testing.assert_array_equal(actual.signal(name), expected.signal(name))


def test_a_given_component_stands_for_one_of_the_scenario(tmp_path: Path) -> None:
    written = {
        "duration": 0.01,
        "components": {"far": {"python": "nowhere:Nothing", "rate": 1024}},
    }
    component = Growing()
    sink = MemorySink()
    assemble(scenario_of(tmp_path, written), {"far": component}).run(sink, until=5)
    np.testing.assert_array_equal(sink.signal("far.value"), [1, 2, 4, 8, 16])
    assert component.setup.name == "far"
