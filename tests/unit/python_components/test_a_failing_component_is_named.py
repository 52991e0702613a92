"""A component that fails during a run: the component, the tick, the time and what it said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmus.probe
from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import Simulation, assemble
from tests.support.master.master_support import scenario_of

PARTS = "tests.support.master.master_parts"


def failing(flavour: str, kind: str, at: int = 100) -> dict[str, Any]:
    probe = str(fmus.probe.find("probe_failure", flavour))
    return {
        "duration": 1,
        "rates": {"control": 1024},
        "components": {
            "good": {"fmu": "hand", "rate": "control", "start": {"force": 1.0}},
            "bad": {"fmu": probe, "rate": "control", "parameters": {"kind": kind, "at": at}},
        },
    }


def fail(folder: Path, written: dict[str, Any]) -> tuple[str, MemorySink, Simulation]:
    sink = MemorySink()
    simulation = assemble(scenario_of(folder, written))
    with pytest.raises(RunError) as caught:
        simulation.run(sink)
    assert caught.value.exit_status == 1
    return str(caught.value), sink, simulation


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
@pytest.mark.parametrize("status", ["discard", "error", "fatal"])
def test_a_status(tmp_path: Path, flavour: str, status: str) -> None:
    said, sink, simulation = fail(tmp_path, failing(flavour, status))
    assert said.startswith(
        f"bad returned status '{status}' from its step at tick 100 (0.0976562 s)"
    )
    assert "This probe fails in the step from 0.09765625 s, as it was told to." in said
    # What was reached is recorded: the row of the failing tick is complete.
    assert len(sink.signal("good.position")) == 101
    assert simulation.outcome.ticks == 100


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_not_a_number(tmp_path: Path, flavour: str) -> None:
    said, sink, _ = fail(tmp_path, failing(flavour, "nan"))
    assert said.startswith("bad.value became NaN at tick 100 (0.0976562 s)")
    assert len(sink.signal("good.position")) == 100
    assert np.isfinite(sink.signal("bad.value")).all()


def test_an_integer_that_does_not_fit(tmp_path: Path) -> None:
    probe = str(fmus.probe.find("probe_types"))
    written = {
        "duration": 1,
        "components": {
            "source": {"python": f"{PARTS}:Growing", "rate": 1024},
            "narrow": {"fmu": probe, "rate": 1024},
        },
        "connections": ["source.value -> narrow.integer_in"],
    }
    said, _, _ = fail(tmp_path, written)
    assert "narrow.integer_in cannot take" in said
    assert "at tick 31" in said


@pytest.mark.parametrize("method", ["evaluate", "step"])
def test_a_python_component(tmp_path: Path, method: str) -> None:
    written = {
        "duration": 1,
        "components": {
            "mine": {
                "python": f"{PARTS}:FailsIn{method.title()}",
                "rate": 1024,
            }
        },
    }
    said, sink, _ = fail(tmp_path, written)
    assert said.startswith(f"mine failed in {method} at tick 7 (0.00683594 s): ZeroDivisionError")
    assert len(sink.signal("mine.value")) == (7 if method == "evaluate" else 8)


def test_every_component_is_closed_after_a_failure(tmp_path: Path) -> None:
    from tests.support.master import master_parts

    master_parts.Growing.closed = 0
    written = failing("fmi3", "error")
    written["components"]["mine"] = {
        "python": f"{PARTS}:Growing",
        "rate": 1024,
    }
    fail(tmp_path, written)
    assert master_parts.Growing.closed == 1


def test_what_was_overridden_is_blamed_for_a_rule_that_names_several(tmp_path: Path) -> None:
    written = {
        "duration": 1,
        "components": {
            "box": {
                "fmu": "distributed_workstation",
                "rate": 1024,
                "parameters": {"mass": 0.4, "inertia": 0.001, "side": 0.1},
            }
        },
    }
    override = "components.box.parameters.side=-1"
    simulation = assemble(scenario_of(tmp_path, written, [override]))
    with pytest.raises(InputError) as caught:
        simulation.run(MemorySink())
    assert str(caught.value).startswith(f"--set {override}: box returned status 'error'")
    assert "mass, inertia and side of the box must be positive." in str(caught.value)
