"""A structural parameter of the scenario gives arrays another size, in any order of writing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of
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
