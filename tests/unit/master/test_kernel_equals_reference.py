"""The kernel gives the bits of a slow loop over FMPy's own interface, on every kind of archive."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmus.probe
from cosim.base.recording import MemorySink
from cosim.master.assembly.assemble import put_together
from cosim.scenario import Scenario
from cosim.testing.reference_loop import ReferenceLoop
from tests.support.master.master_support import run, scenario_of
from tests.support.master.single_axis import ARCHITECTURES, GAINS, single_axis

CHANNEL = {
    "round_trip_delay": 1,
    "jitter": {"weights": [0.5, 0.3, 0.2], "step": "1 ticks"},
    "loss": 0.2,
    "reorder": {"probability": 0.2, "by": "11 ticks"},
}
TICKS = 100


def assert_same(scenario: Scenario, ticks: int = TICKS) -> None:
    """Every recorded signal has the same bits in both loops."""
    sink, _ = run(scenario, until=ticks)
    expected = ReferenceLoop(put_together(scenario)).run(ticks)
    names = [column.name for group in sink.groups for column in group.columns]
    assert sorted(expected) == sorted(names)
    assert len(names) >= 5
    for name in names:
        np.testing.assert_array_equal(
            sink.signal(name).view(np.int64), expected[name].view(np.int64), err_msg=name
        )


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
@pytest.mark.parametrize("name", ARCHITECTURES)
def test_on_the_single_axis(tmp_path: Path, name: str, flavour: str) -> None:
    assert_same(single_axis(tmp_path, name, GAINS[name]["soft"], CHANNEL, flavour=flavour))


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_on_a_user_with_device_and_workstation(tmp_path: Path, flavour: str) -> None:
    def component(model: str) -> dict[str, Any]:
        return {"fmu": model, "rate": 1024, "flavour": flavour}

    written = {
        "duration": 1,
        "components": {name: component(name) for name in ("pantograph", "operator")}
        | {"vr": component("distributed_workstation")},
        "connections": [
            "pantograph.device -> vr.finger_1",
            "vr.finger_1 -> pantograph.device",
            "pantograph.tip_position -> operator.position",
            "pantograph.tip_velocity -> operator.velocity",
            "operator.force -> pantograph.hand_force",
        ],
    }
    assert_same(scenario_of(tmp_path, written))


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
@pytest.mark.parametrize("feedthrough", [True, False])
def test_on_variables_of_every_type(tmp_path: Path, flavour: str, feedthrough: bool) -> None:
    probe = {
        "fmu": str(fmus.probe.find("probe_types", flavour)),
        "rate": 1024,
        "feedthrough": feedthrough,
        "parameters": {"enumeration_parameter": "green", "strings_parameter": ["a", "b"]},
    }
    kinds = ("real", "integer", "boolean", "enumeration", "reals", "integers", "booleans")
    written = {
        "duration": 1,
        "rates": {"slow": 128},
        "components": {"a": probe, "b": {**probe, "rate": "slow", "feedthrough": True}},
        "connections": [
            *(f"a.{kind}_out -> b.{kind}_in" for kind in kinds),
            *(
                {
                    "from": f"b.{kind}_out",
                    "to": f"a.{kind}_in",
                    "rate": 512,
                    "delay": "3 ticks",
                    "initial": "start",
                }
                for kind in kinds[1:]
            ),
            "b.integer_out -> a.real_in delay 1",
        ],
    }
    assert_same(scenario_of(tmp_path, written))


def test_on_substeps(tmp_path: Path) -> None:
    probe = {"fmu": str(fmus.probe.find("probe_substeps")), "rate": 1024, "substeps": 4}
    written = {
        "duration": 1,
        "components": {"a": {**probe, "start": {"rate": 0.1}}, "b": {**probe, "rate": 512}},
        "record": ["a.*", "b.*", "a.rate"],
    }
    written["components"]["b"]["substeps"] = 8
    assert_same(scenario_of(tmp_path, written))


def everything(sink: MemorySink) -> dict[str, bytes]:
    return {
        column.name: sink.signal(column.name).tobytes()
        for group in sink.groups
        for column in group.columns
    }


def test_archives_of_both_versions_give_the_same_bytes(tmp_path: Path) -> None:
    gains = GAINS["distributed"]["soft"]
    found = [
        everything(run(single_axis(tmp_path, "distributed", gains, CHANNEL, flavour=flavour))[0])
        for flavour in ("fmi2", "fmi3", "fmi3-arrays")
    ]
    assert found[0] == found[1] == found[2]


def test_the_same_seed_gives_the_same_bytes_and_order_is_irrelevant(tmp_path: Path) -> None:
    def bytes_of(**more: Any) -> dict[str, bytes]:
        gains = GAINS["distributed"]["soft"]
        scenario = single_axis(tmp_path, "distributed", gains, CHANNEL, more={"seed": 3, **more})
        return everything(run(scenario)[0])

    first = bytes_of()
    assert bytes_of() == first
    assert bytes_of(seed=4) != first

    scenario = single_axis(tmp_path, "distributed", GAINS["distributed"]["soft"], CHANNEL)
    turned = replace(
        scenario,
        seed=3,
        components=dict(reversed(scenario.components.items())),
        connections=scenario.connections[::-1],
    )
    assert everything(run(turned)[0]) == first
