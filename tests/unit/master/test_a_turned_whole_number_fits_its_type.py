"""What events, hands and connections turn is as whole, and as small, as the parameter's type."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError, RunError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

LIMITS = {
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32)},
    "UInt64": (0, 2**63 - 1),  # a cell has 64 bits with a sign
}
BEYOND = [
    (kind, text)
    for kind, (low, high) in LIMITS.items()
    for text in (str(low - 1), str(high + 1), "1.0e300", "0.5", "true", "two")
]
WORDS = [
    ("Enumeration", "3"),
    ("Enumeration", "1.5"),
    ("Enumeration", "2.0"),
    ("Enumeration", "true"),
    ("Enumeration", "violet"),
    ("Boolean", "1"),
    ("Boolean", "0.5"),
    ("Boolean", "'yes'"),
]
TYPES = """<TypeDefinitions><EnumerationType name="Colour"><Item name="red" value="1"/>
<Item name="blue" value="2"/></EnumerationType></TypeDefinitions>"""
SHOWS = """
    static int hook(Foreign *m, const char *call)
    {
        m->whole[2] = m->whole[1];
        return 0;
    }
    #define HOOK hook
"""


def fmu_of(folder: Path, kind: str, version: int = 3) -> Path:
    """Its output is its tunable parameter of that type."""
    start = {"Enumeration": "1", "Boolean": "false"}.get(kind, "0")
    more: dict[str, Any] = {"declaredType": "Colour"} if kind == "Enumeration" else {}
    tunable = {"causality": "parameter", "variability": "tunable", "start": start}
    variables = scalar(version, "p", 1, kind, **more, **tunable)
    variables += scalar(version, "y", 2, kind, **more, causality="output")
    structure = {
        2: '<Outputs><Unknown index="2" dependencies=""/></Outputs>',
        3: '<Output valueReference="2" dependencies=""/>',
    }[version]
    before = TYPES if kind == "Enumeration" else ""
    return foreign_fmu(
        folder, version, variables, structure=structure, before=before, snippet=SHOWS
    )


def text_of(fmu: Path, value: object, more: str = "") -> str:
    return (
        f"duration: 4\nbase_rate: 1\ncomponents:\n  f: {{fmu: {fmu}, rate: 1}}\n{more}"
        f"events:\n  - at: 1\n    set:\n      f.p: {value}\n"
    )


def refused(folder: Path, fmu: Path, value: str) -> None:
    with pytest.raises(InputError, match=r"f\.p ") as caught:
        assemble(scenario_of(folder, text_of(fmu, value)))
    place = caught.value.location
    assert place is not None
    assert (Path(place.file).name, place.line) == ("test.yaml", 9)


@pytest.mark.parametrize(("kind", "value"), [*BEYOND, *WORDS])
def test_an_event_is_refused_in_its_line(tmp_path: Path, kind: str, value: str) -> None:
    refused(tmp_path, fmu_of(tmp_path, kind), value)


@pytest.mark.parametrize("value", [str(2**31), str(-(2**31) - 1), "1.0e300", "0.5"])
def test_so_it_is_of_an_integer_of_fmi_2(tmp_path: Path, value: str) -> None:
    refused(tmp_path, fmu_of(tmp_path, "Int32", 2), value)


@pytest.mark.parametrize(("kind", "limits"), LIMITS.items())
def test_the_least_and_the_most_are_turned_to(
    tmp_path: Path, kind: str, limits: tuple[int, int]
) -> None:
    fmu = fmu_of(tmp_path, kind)
    for value in limits:
        sink, _ = run(scenario_of(tmp_path, text_of(fmu, value)))
        assert sink.signal("f.p").tolist() == [0, value, value, value]
        assert sink.signal("f.y").tolist()[-1] == value


@pytest.mark.parametrize(
    ("kind", "value", "number"), [("Enumeration", "blue", 2), ("Boolean", "true", 1)]
)
def test_words_are_turned_to(tmp_path: Path, kind: str, value: str, number: int) -> None:
    sink, _ = run(scenario_of(tmp_path, text_of(fmu_of(tmp_path, kind), value)))
    assert sink.signal("f.y").tolist()[-1] == number


@pytest.mark.parametrize("kind", ["Int8", "UInt16", "UInt32", "UInt64"])
def test_by_hand(tmp_path: Path, kind: str) -> None:
    low, high = LIMITS[kind]
    with assemble(scenario_of(tmp_path, text_of(fmu_of(tmp_path, kind), 1))) as simulation:
        for value in (low - 1, high + 1, 0.5, 1e300):
            with pytest.raises(InputError, match=r"f\.p is"):
                simulation.set({"f.p": value})
        simulation.set({"f.p": high})


def source(folder: Path, number: int) -> Path:
    """Puts a whole number out from its first step on."""
    snippet = f"""
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "DoStep"))
                m->whole[1] = {number}LL;
            return 0;
        }}
        #define HOOK hook
    """
    output = '<Output valueReference="1" dependencies=""/>'
    variables = scalar(3, "y", 1, "Int64", causality="output")
    return foreign_fmu(folder, 3, variables, snippet=snippet, structure=output, name="source")


@pytest.mark.parametrize(("kind", "number"), [("Int8", 300), ("UInt8", -1), ("Int32", 2**31)])
def test_a_connection_that_carries_too_much_ends_the_run(
    tmp_path: Path, kind: str, number: int
) -> None:
    low, high = LIMITS[kind]
    text = (
        f"duration: 4\nbase_rate: 1\ncomponents:\n  f: {{fmu: {fmu_of(tmp_path, kind)}, rate: 1}}\n"
        f"  g: {{fmu: {source(tmp_path, number)}, rate: 1}}\nconnections: [g.y -> f.p]\n"
    )
    goes = re.escape(f"it goes from {low:g} to {high:g}")
    with pytest.raises(
        RunError, match=rf"f\.p was turned to .* by g\.y -> f\.p at tick 1 \(1 s\): {goes}"
    ):
        run(scenario_of(tmp_path, text))
