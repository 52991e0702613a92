"""A structural parameter of the scenario gives arrays another size, in any order of writing."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Any

import pytest

import fmus
from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of


@pytest.fixture
def resizable(tmp_path: Path) -> Path:
    """The pantograph with an ``initial_tip_position`` of ``n`` elements; it is never run."""
    path = tmp_path / "resizable.fmu"
    with zipfile.ZipFile(fmus.find("pantograph", "fmi3-arrays")) as old:
        contents = {name: old.read(name) for name in old.namelist()}
    text = contents["modelDescription.xml"].decode()
    variable = re.search(r'<Float64 name="initial_tip_position".*?</Float64>', text, re.DOTALL)
    assert variable is not None
    changed = variable[0].replace('<Dimension start="2" />', '<Dimension valueReference="9999"/>')
    assert changed != variable[0]
    size = '<UInt64 name="n" valueReference="9999" causality="structuralParameter" start="2"/>'
    contents["modelDescription.xml"] = text.replace(variable[0], size + changed).encode()
    with zipfile.ZipFile(path, "w") as new:
        for name, content in contents.items():
            new.writestr(name, content)
    return path


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
