"""A value in the wrong shape, or for a variable that has none to give, is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

SIZE = '<Dimension start="2"/><Dimension start="3"/>'
MATRIX = scalar(
    3, "m", 1, inside=SIZE, causality="parameter", variability="fixed", start="1 2 3 4 5 6"
)
OUT = scalar(3, "y", 1, inside=SIZE, causality="output", start="0", initial="exact")
STRUCTURE = '<Output valueReference="1" dependencies=""/>'


def scenario(folder: Path, given: str):
    fmu = foreign_fmu(folder, 3, MATRIX + OUT, structure=STRUCTURE)
    text = (
        f"duration: 0.2\ncomponents:\n  it: {{fmu: {fmu}, rate: 10, parameters: {{m: {given}}}}}\n"
    )
    return scenario_of(folder, text)


@pytest.mark.parametrize("given", ["[[7, 8, 9], [10, 11, 12]]", "[7, 8, 9, 10, 11, 12]"])
def test_lists_in_a_list_and_a_list_are_the_same(tmp_path: Path, given: str) -> None:
    sink, _ = run(scenario(tmp_path, given))
    found = [sink.signal(f"it.y[{i},{j}]")[0] for i in (1, 2) for j in (1, 2, 3)]
    assert found == [7, 8, 9, 10, 11, 12]


@pytest.mark.parametrize(
    "given", ["[[7, 8], [9, 10], [11, 12]]", "[[7], 8, 9, 10, 11, 12]", "[[7, 8, 9, 10], [11, 12]]"]
)
def test_another_shape_is_refused(tmp_path: Path, given: str) -> None:
    with pytest.raises(InputError, match=r"it\.m is 2 × 3; give a list of its 6 values"):
        assemble(scenario(tmp_path, given))


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("causality", ["output", "local"])
def test_what_the_fmu_calculates_has_no_start_to_give(
    tmp_path: Path, version: int, causality: str
) -> None:
    """FMI 2.0.4, section 2.2.7, and FMI 3.0.2, section 2.4.7.5: only exact and approx are set."""
    own = scalar(version, "own", 1, causality=causality)
    free = scalar(version, "free", 2, causality=causality, start="0", initial="approx")
    structure = (
        ""
        if causality == "local"
        else {
            2: '<Outputs><Unknown index="1"/><Unknown index="2"/></Outputs>',
            3: '<Output valueReference="1"/><Output valueReference="2"/>',
        }[version]
    )
    fmu = foreign_fmu(tmp_path, version, own + free, structure=structure)
    text = "duration: 0.2\ncomponents:\n  it: {{fmu: {0}, rate: 10, start: {{{1}: 4}}}}\n"
    assemble(scenario_of(tmp_path, text.format(fmu, "free")))
    with pytest.raises(InputError, match=r"it\.own has no start: the FMU calculates its first"):
        assemble(scenario_of(tmp_path, text.format(fmu, "own")))
