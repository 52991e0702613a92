"""Whatever our models call tunable is wired like an input, and acts as an event at that tick."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmus
from cosim.base.component import Variable
from cosim.master.components.interface import is_tunable
from cosim.master.fmu.reading import read_description
from fmus.names import model_names
from tests.support.master.master_support import run, scenario_of

RATE, TICKS, TURNED = 1024, 48, 17
NAMED = {
    "virtual_coupler": {"stiffness", "damping"},
    "distributed_workstation": {"compensation.x", "coupling_stiffness", "coupling_damping"},
    "operator": {"stiffness[1]", "damping[2]"},
    "object": {"wall_stiffness", "wall_damping"},
    "signal": {"amplitude", "offset"},
}
"""Some of what the pages name."""


@cache
def tunable(model: str) -> tuple[Variable, ...]:
    variables = read_description(fmus.find(model, "fmi3")).variables.values()
    return tuple(each for each in variables if is_tunable(each))


MODELS = [name for name in model_names() if tunable(name)]


def values_of(variable: Variable) -> tuple[float, float]:
    """Where it stands, and where it is turned to, within its limits."""
    before = float(variable.start or 0.0)
    after = 1.5 * before + 0.25
    if variable.maximum is not None and after > variable.maximum:
        after = variable.maximum / 2
    assert after != before
    return before, after


def scenario(folder: Path, model: str, flavour: str, **more: Any) -> Any:
    component = {"fmu": model, "flavour": flavour, "rate": RATE}
    parts = {"it": component, **more.pop("components", {})}
    return scenario_of(folder, {"duration": TICKS / RATE, "components": parts, **more})


def test_the_pages_name_what_there_is() -> None:
    for model, names in NAMED.items():
        assert names <= {each.name for each in tunable(model)}, model
    assert set(NAMED) <= set(MODELS)


@pytest.mark.parametrize("model", MODELS)
def test_a_connection_turns_it_as_an_event_does(tmp_path: Path, model: str) -> None:
    """Real numbers by a signal each; the words of an enumeration are turned by events alone."""
    knobs = [each for each in tunable(model) if each.type.is_float]
    assert all(each.items for each in tunable(model) if each not in knobs)
    parts, wires, turned = {}, [], {}
    for number, variable in enumerate(knobs):
        before, after = values_of(variable)
        step = {"mode": "step", "start_time": TURNED / RATE, "offset": before}
        parts[f"knob{number}"] = {
            "fmu": "signal", "rate": RATE, "parameters": step | {"amplitude": after - before},
        }  # fmt: skip
        wires.append({"from": f"knob{number}.value", "to": f"it.{variable.name}"})
        turned[f"it.{variable.name}"] = before + (after - before)
    wired, _ = run(scenario(tmp_path, model, "fmi3", components=parts, connections=wires))
    events = [{"at": f"{TURNED} ticks", "set": turned}]
    by_event, _ = run(scenario(tmp_path, model, "fmi3", events=events))
    names = [c.name for group in by_event.groups for c in group.columns]
    assert {f"it.{each.name}" for each in knobs} <= set(names)
    for name in names:
        np.testing.assert_array_equal(wired.signal(name), by_event.signal(name), name)
    for variable in knobs:
        found = by_event.signal(f"it.{variable.name}")
        assert found[TURNED - 1] != found[TURNED]
