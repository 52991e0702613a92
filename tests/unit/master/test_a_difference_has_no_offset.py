"""``relativeQuantity``: a difference of temperatures is converted without the unit's offset."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

UNITS = {
    3: '<UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="K"><BaseUnit K="1"/></Unit></UnitDefinitions>',
}
UNITS[2] = UNITS[3]


def fmu(folder: Path, version: int, unit: str, relative: str, name: str) -> Path:
    more = {"unit": unit, "relativeQuantity": relative} if relative else {"unit": unit}
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
            m->real[2] = m->real[1] + 20;
            return 0;
        }
        #define HOOK hook
    """
    variables = scalar(version, "u", 1, causality="input", start="0", **more) + scalar(
        version, "y", 2, causality="output", **more
    )
    structure = '<Output valueReference="2" dependencies=""/>'
    if version == 2:
        structure = '<Outputs><Unknown index="2" dependencies=""/></Outputs>'
    return foreign_fmu(
        folder,
        version,
        variables,
        snippet=snippet,
        structure=structure,
        before=UNITS[version],
        name=name,
    )


def joined(folder: Path, version: int, there: str, here: str) -> str:
    """From degC to K."""
    a, b = fmu(folder, version, "degC", there, "a"), fmu(folder, version, "K", here, "b")
    return (
        f"duration: 3\nbase_rate: 1\ncomponents:\n  a: {{fmu: {a}, rate: 1}}\n"
        f"  b: {{fmu: {b}, rate: 1}}\nconnections: [a.y -> b.u]\nrecord: [b.u]\n"
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("relative", "kelvin"), [("true", 20.0), ("false", 293.15), ("", 293.15)])
def test_a_difference_is_converted_without_the_offset(
    tmp_path: Path, version: int, relative: str, kelvin: float
) -> None:
    sink, _ = run(scenario_of(tmp_path, joined(tmp_path, version, relative, relative)))
    assert sink.signal("b.u")[-1] == kelvin


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("here", ["false", ""])
def test_a_difference_does_not_drive_an_absolute_value(
    tmp_path: Path, version: int, here: str
) -> None:
    a, b = (
        fmu(tmp_path, version, "degC", relative, name)
        for relative, name in (("true", "a"), (here, "b"))
    )
    written = (
        f"duration: 3\nbase_rate: 1\ncomponents:\n  a: {{fmu: {a}, rate: 1}}\n"
        f"  b: {{fmu: {b}, rate: 1}}\nconnections: [a.y -> b.u]\n"
    )
    with pytest.raises(InputError, match=r"one is a difference .* an absolute value in degC"):
        run(scenario_of(tmp_path, written))
