"""With ``feedthrough: true`` the structure is believed: absent means all, empty none."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

FOLLOWS = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "GetReal") || is(call, "GetFloat64"))
            m->real[2] = m->real[1] + 1;
        return 0;
    }
    #define HOOK hook
"""
"""The output is the input and one, at once."""

ABSENT, NONE, ALL, LEFT_OUT = "", 'dependencies=""', 'dependencies="1"', None


def follower(folder: Path, version: int, attribute: str | None) -> Path:
    variables = scalar(version, "u", 1, causality="input", start="0") + scalar(
        version, "y", 2, causality="output"
    )
    structure = ""
    if attribute is not None and version == 2:
        structure = f'<Outputs><Unknown index="2" {attribute}/></Outputs>'
    elif attribute is not None:
        structure = f'<Output valueReference="2" {attribute}/>'
    return foreign_fmu(folder, version, variables, snippet=FOLLOWS, structure=structure)


def chain(fmu: Path, *, is_closed: bool = False) -> str:
    component = f"{{fmu: {fmu}, rate: 1, feedthrough: true}}"
    names = ["a", "b", "c"]
    arrows = ["a.y -> b.u", "b.y -> c.u", *(["c.y -> a.u"] if is_closed else [])]
    listed = "".join(f"  {name}: {component}\n" for name in names)
    return (
        f"duration: 3\nbase_rate: 1\ncomponents:\n{listed}"
        f"connections: [{', '.join(arrows)}]\nrecord: [c.y]\n"
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("attribute", [ABSENT, ALL])
def test_an_output_that_says_nothing_depends_on_every_input(
    tmp_path: Path, version: int, attribute: str
) -> None:
    sink, _ = run(scenario_of(tmp_path, chain(follower(tmp_path, version, attribute))))
    assert sink.signal("c.y").tolist() == [3.0, 3.0, 3.0]


@pytest.mark.parametrize("version", [2, 3])
def test_a_circle_of_them_is_an_algebraic_loop(tmp_path: Path, version: int) -> None:
    looped = scenario_of(tmp_path, chain(follower(tmp_path, version, ABSENT), is_closed=True))
    with pytest.raises(InputError, match="loop"):
        assemble(looped)
    assemble(scenario_of(tmp_path, chain(follower(tmp_path, version, NONE), is_closed=True)))


def test_an_output_that_the_structure_leaves_out_may_depend_on_anything(tmp_path: Path) -> None:
    looped = scenario_of(tmp_path, chain(follower(tmp_path, 3, LEFT_OUT), is_closed=True))
    with pytest.raises(InputError, match="loop"):
        assemble(looped)
