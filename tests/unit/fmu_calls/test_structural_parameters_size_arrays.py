"""A structural parameter of the scenario gives arrays another size, in any order of writing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of
from tests.support.master.resizable import with_resizable_array


@pytest.fixture
def resizable(tmp_path: Path) -> Path:
    """The pantograph with an ``initial_tip_position`` of ``n`` elements; it is never run."""
    return with_resizable_array(tmp_path)


def parameters(folder: Path, fmu: Path, written: dict[str, Any]) -> dict[str, list[Any]]:
    component = {"fmu": str(fmu), "rate": 1024, "parameters": written}
    scenario = scenario_of(folder, {"duration": 1, "components": {"m": component}})
    return assemble(scenario).assembly.participants["m"].parameters


@pytest.mark.parametrize("order", [1, -1])
def test_the_list_has_as_many_values_as_the_parameter_says(
    resizable: Path, tmp_path: Path, order: int
) -> None:
    written = {"initial_tip_position": [0.1, 0.2, 0.3], "n": 3}
    written = dict(list(written.items())[::order])
    assert parameters(tmp_path, resizable, written) == written | {"n": [3]}
    with pytest.raises(InputError, match="initial_tip_position has 3 elements; give a list of 3"):
        parameters(tmp_path, resizable, {**written, "initial_tip_position": [0.1, 0.2]})


DOUBLES = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "Instantiate"))
            m->whole[60] = 2;
        if (is(call, "DoStep"))
            for (int i = 0; i < m->whole[60]; i++)
                m->real[20 + i] = 2 * m->real[1 + i];
        return 0;
    }
    #define HOOK hook
"""
"""Each element of ``y`` is twice that of ``u``, a step late; both have ``n`` elements."""


def doubling(folder: Path) -> Path:
    size = {"causality": "structuralParameter", "variability": "fixed", "start": "2"}
    by_n = '<Dimension valueReference="60"/>'
    variables = (
        scalar(3, "n", 60, "UInt64", **size)
        + scalar(3, "u", 1, inside=by_n, causality="input", start="1 1")
        + scalar(3, "y", 20, inside=by_n, causality="output")
    )
    output = '<Output valueReference="20" dependencies=""/>'
    return foreign_fmu(folder, 3, variables, structure=output, snippet=DOUBLES)


@pytest.mark.parametrize("keys", [{}, {"isolate": "process"}])
@pytest.mark.parametrize("n", [1, 2, 7])
def test_a_run_computes_with_as_many_elements(tmp_path: Path, n: int, keys: dict[str, str]) -> None:
    part = {"fmu": str(doubling(tmp_path)), "rate": 10, "parameters": {"n": n}, **keys}
    first = {**part, "start": {"u": [float(i + 1) for i in range(n)]}}
    written = {
        "duration": 0.5,
        "components": {"a": first, "b": part},
        "connections": ["a.y -> b.u"],
    }
    sink, simulation = run(scenario_of(tmp_path, written))
    names = [column.name for group in sink.groups for column in group.columns]
    assert sum(name.startswith("b.y") for name in names) == n
    found = [sink.signal(f"b.y[{i + 1}]")[-1] for i in range(n)]
    assert found == [4.0 * (i + 1) for i in range(n)]
    assert simulation.assembly.participants["a"].parameters["n"] == [n]


def test_another_number_of_elements_does_not_fit(tmp_path: Path) -> None:
    part = {"fmu": str(doubling(tmp_path)), "rate": 10}
    written = {
        "duration": 0.5,
        "components": {"a": {**part, "parameters": {"n": 3}}, "b": part},
        "connections": ["a.y -> b.u"],
    }
    with pytest.raises(InputError, match=r"a\.y has 3 elements and b\.u 2"):
        assemble(scenario_of(tmp_path, written))
