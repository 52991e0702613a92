"""An array of an enumeration is written by names or numbers, carried whole, kept in its range."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError, RunError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

TYPES = """<TypeDefinitions><EnumerationType name="Colour"><Item name="red" value="1"/>
<Item name="blue" value="2"/><Item name="green" value="5"/></EnumerationType></TypeDefinitions>"""
TWO = '<Dimension start="2"/>'
SNIPPET = """
    static int hook(Foreign *m, const char *call)
    {
        m->whole[20] = m->whole[10];
        m->whole[21] = SECOND;
        m->real[30] = 10.0 * m->whole[1] + m->whole[2];
        return 0;
    }
    #define HOOK hook
"""


def fmu_of(folder: Path, name: str = "foreign", second: str = "m->whole[11]") -> Path:
    common = {"kind": "Enumeration", "inside": TWO, "declaredType": "Colour"}
    variables = "\n".join(
        [
            scalar(
                3, "given", 1, **common, causality="parameter", variability="fixed", start="1 2"
            ),
            scalar(3, "heard", 10, **common, causality="input", start="5 5"),
            scalar(3, "said", 20, **common, causality="output"),
            scalar(3, "sum", 30, causality="output"),
        ]
    )
    structure = "".join(f'<Output valueReference="{n}" dependencies=""/>' for n in (20, 30))
    snippet = SNIPPET.replace("SECOND", second)
    return foreign_fmu(
        folder, 3, variables, snippet=snippet, structure=structure, before=TYPES, name=name
    )


def scenario_text(fmu: Path, given: str, more: str = "") -> str:
    return (
        f"duration: 3\nbase_rate: 1\ncomponents:\n  f:\n    fmu: {fmu}\n    rate: 1\n"
        f"    parameters:\n      given: {given}\n{more}record: [f.*]\n"
    )


@pytest.mark.parametrize("given", ["[blue, green]", "[2, 5]", "[blue, 5]"])
def test_names_and_numbers_reach_the_fmu(tmp_path: Path, given: str) -> None:
    heard = "    start:\n      heard: [green, red]\n"
    sink, _ = run(scenario_of(tmp_path, scenario_text(fmu_of(tmp_path), given, heard)))
    assert sink.signal("f.sum")[-1] == 25.0
    assert [sink.signal(f"f.said[{n}]")[-1] for n in (1, 2)] == [5, 1]


@pytest.mark.parametrize("given", ["[blue, 3]", "[blue, violet]", "[1, 6]", "[1]", "blue"])
def test_what_is_no_value_of_it_is_refused_in_its_line(tmp_path: Path, given: str) -> None:
    with pytest.raises(InputError, match=r"f\.given") as caught:
        assemble(scenario_of(tmp_path, scenario_text(fmu_of(tmp_path), given)))
    assert caught.value.location is not None
    assert caught.value.location.line == 9


def test_it_crosses_a_connection_whole(tmp_path: Path) -> None:
    fmu = fmu_of(tmp_path)
    more = (
        f"  g:\n    fmu: {fmu}\n    rate: 1\n    start:\n      heard: [red, blue]\n"
        "connections:\n  - g.said -> f.heard\n"
    )
    sink, _ = run(scenario_of(tmp_path, scenario_text(fmu, "[1, 1]", more)))
    assert [sink.signal(f"f.said[{n}]")[-1] for n in (1, 2)] == [1, 2]


def test_a_knob_is_turned_to_what_has_a_name_alone(tmp_path: Path) -> None:
    """By a connection, too: 3 lies between blue and green, and is neither."""
    colour = {"kind": "Enumeration", "declaredType": "Colour"}
    turned = scalar(3, "mode", 1, **colour, causality="parameter", variability="tunable", start="1")
    said = scalar(3, "said", 20, **colour, causality="output")
    output = '<Output valueReference="20" dependencies=""/>'
    for number, is_one in ((2, True), (3, False)):
        snippet = (
            "static int hook(Foreign *m, const char *call) "
            f"{{ m->whole[20] = {number}; return 0; }}\n#define HOOK hook\n"
        )
        fmu = foreign_fmu(
            tmp_path, 3, turned + said, snippet=snippet, structure=output, before=TYPES
        )
        text = (
            f"duration: 3\nbase_rate: 1\ncomponents:\n  f: {{fmu: {fmu}, rate: 1}}\n"
            f"  g: {{fmu: {fmu}, rate: 1}}\nconnections:\n  - g.said -> f.mode\nrecord: [f.*]\n"
        )
        if is_one:
            run(scenario_of(tmp_path, text))
        else:
            with pytest.raises(RunError, match=r"f\.mode was turned to 3 by .*: it is one of red"):
                run(scenario_of(tmp_path, text))


def test_a_number_that_names_nothing_crosses_no_connection(tmp_path: Path) -> None:
    wrong = fmu_of(tmp_path, "wrong", second="3")
    more = (
        f"  g:\n    fmu: {wrong}\n    rate: 1\n    start:\n      heard: [red, blue]\n"
        "connections:\n  - g.said -> f.heard\n"
    )
    with pytest.raises(RunError, match=r"f\.heard\[2\] cannot take 3"):
        run(scenario_of(tmp_path, scenario_text(fmu_of(tmp_path), "[1, 1]", more)))
