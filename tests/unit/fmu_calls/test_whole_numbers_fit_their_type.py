"""A whole number is carried as it is or refused with its place: none is wrapped, none is cut."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import pytest

from cosim.base.errors import InputError, InputErrors, RunError
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
    for text in (str(low - 1), str(high + 1), "1.0e300", "1.0e19", "0.5")
]


def fmu_of(folder: Path, kind: str, version: int = 3, **start: str) -> Path:
    variables = "\n".join(
        [
            scalar(version, "u", 1, kind, causality="input", start=start.get("u", "0")),
            scalar(
                version,
                "p",
                2,
                kind,
                causality="parameter",
                variability="fixed",
                start=start.get("p", "0"),
            ),
            scalar(version, "y", 3, kind, causality="output"),
        ]
    )
    output = '<Output valueReference="3" dependencies=""/>'
    if version == 2:
        output = '<Outputs><Unknown index="3" dependencies=""/></Outputs>'
    return foreign_fmu(folder, version, variables, structure=output)


def scenario_text(fmu: Path, more: str = "") -> str:
    return (
        f"duration: 2\nbase_rate: 1\ncomponents:\n  f:\n    fmu: {fmu}\n    rate: 1\n"
        f"{more}record: [f.u]\n"
    )


@pytest.mark.parametrize(("kind", "text"), BEYOND)
@pytest.mark.parametrize("section", ["start", "parameters"])
def test_what_a_scenario_gives_is_refused_in_its_line(
    tmp_path: Path, section: str, kind: str, text: str
) -> None:
    name = {"start": "u", "parameters": "p"}[section]
    written = scenario_text(fmu_of(tmp_path, kind), f"    {section}:\n      {name}: {text}\n")
    with pytest.raises(
        InputError, match=rf"f\.{name} is (of type {kind}|a whole number)"
    ) as caught:
        assemble(scenario_of(tmp_path, written))
    place = caught.value.location
    assert place is not None
    assert (Path(place.file).name, place.line) == ("test.yaml", 9)


@pytest.mark.parametrize(("kind", "limits"), LIMITS.items())
def test_the_least_and_the_most_are_taken(
    tmp_path: Path, kind: str, limits: tuple[int, int]
) -> None:
    for value in limits:
        more = f"    start:\n      u: {value}\n    parameters:\n      p: {value}\n"
        sink, _ = run(scenario_of(tmp_path, scenario_text(fmu_of(tmp_path, kind), more)))
        assert sink.signal("f.u").tolist() == [value, value]


@pytest.mark.parametrize("text", [str(2**31), "1.0e300", str(-(2**31) - 1)])
def test_an_integer_of_fmi_2_has_32_bits(tmp_path: Path, text: str) -> None:
    written = scenario_text(fmu_of(tmp_path, "Int32", 2), f"    start:\n      u: {text}\n")
    with pytest.raises(InputError, match=r"f\.u is of type Int32, which goes from -2147483648 to"):
        assemble(scenario_of(tmp_path, written))


NO_NUMBERS = [
    *((kind, text) for kind in LIMITS for text in ("abc", "1_0", "\u0663", "0x10", "true")),
    *((kind, text) for kind in ("Float32", "Float64") for text in ("abc", "1_0", "\u0663")),
]
"""What Python takes for a number, some of it, and XML does not."""


def xml_refusal(folder: Path, fmu: Path, name: str) -> str:
    """What is said of a variable, behind its line, which is where it stands."""
    with zipfile.ZipFile(fmu) as archive:
        lines = archive.read("modelDescription.xml").decode().splitlines()
    line = next(n for n, text in enumerate(lines, 1) if f'name="{name}"' in text)
    with pytest.raises(InputError) as caught:
        assemble(scenario_of(folder, scenario_text(fmu)))
    said = f"line {line} of the modelDescription.xml of {fmu}: {name}: "
    assert said in str(caught.value)
    return str(caught.value).partition(said)[2]


@pytest.mark.parametrize(("kind", "text"), BEYOND)
@pytest.mark.parametrize("name", ["u", "p"])
def test_what_the_xml_gives_beyond_its_type_is_refused_in_its_line(
    tmp_path: Path, name: str, kind: str, text: str
) -> None:
    said = xml_refusal(tmp_path, fmu_of(tmp_path, kind, **{name: text}), name)
    if not re.fullmatch(r"-?\d+", text):
        assert said == f"its start, {text}, is not of type {kind}"
        return
    low, high = LIMITS[kind]
    here = " here" if kind == "UInt64" else ""
    assert said == (
        f"its start is of type {kind}, which goes from {low} to {high}{here}, and cannot be {text}"
    )


@pytest.mark.parametrize(("kind", "text"), NO_NUMBERS)
def test_what_is_no_number_in_the_xml_is_refused_in_its_line(
    tmp_path: Path, kind: str, text: str
) -> None:
    said = xml_refusal(tmp_path, fmu_of(tmp_path, kind, u=text), "u")
    assert said == f"its start, {text}, is not of type {kind}"


@pytest.mark.parametrize("text", [str(2**31), str(-(2**31) - 1), "1e3"])
def test_an_integer_of_fmi_2_is_refused_in_its_line_of_the_xml(tmp_path: Path, text: str) -> None:
    said = xml_refusal(tmp_path, fmu_of(tmp_path, "Int32", 2, u=text), "u")
    assert text in said
    assert "of type Int32" in said


@pytest.mark.parametrize("bound", ["min", "max"])
def test_a_bound_that_is_no_number_is_refused_in_its_line(tmp_path: Path, bound: str) -> None:
    variable = scalar(3, "u", 1, "Int8", causality="input", start="0", **{bound: "many"})
    said = xml_refusal(tmp_path, foreign_fmu(tmp_path, 3, variable), "u")
    assert said == f"its {bound}, many, is no number"


@pytest.mark.parametrize(("kind", "limits"), LIMITS.items())
def test_the_least_and_the_most_of_the_xml_are_taken(
    tmp_path: Path, kind: str, limits: tuple[int, int]
) -> None:
    for value in limits:
        fmu = fmu_of(tmp_path, kind, u=str(value), p=str(value))
        sink, _ = run(scenario_of(tmp_path, scenario_text(fmu)))
        assert sink.signal("f.u").tolist() == [value, value]


def test_a_real_that_a_float32_cannot_hold_is_refused(tmp_path: Path) -> None:
    written = scenario_text(fmu_of(tmp_path, "Float32"), "    start:\n      u: 1.0e300\n")
    with pytest.raises(InputError, match=r"f\.u is of type Float32"):
        assemble(scenario_of(tmp_path, written))


def source(folder: Path, kind: str, value: str) -> Path:
    """Puts ``value`` out from its second step on, unchecked."""
    snippet = f"""
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "DoStep"))
                m->whole[1] = (int64_t){value};
            return 0;
        }}
        #define HOOK hook
    """
    output = '<Output valueReference="1" dependencies=""/>'
    variables = scalar(3, "y", 1, kind, causality="output")
    return foreign_fmu(
        folder, 3, variables, snippet=snippet, structure=output, name=f"source_{kind}"
    )


JOINED = [
    ("Int16", "300", "Int8", 300),
    ("Int8", "-1", "UInt8", -1),
    ("Int64", "1LL << 31", "Int32", 2**31),
    ("Int64", "1LL << 32", "UInt32", 2**32),
    ("Int64", "-1", "UInt64", -1),
]


@pytest.mark.parametrize(("kind", "value", "into", "number"), JOINED)
def test_what_a_connection_carries_is_refused_at_its_tick(
    tmp_path: Path, kind: str, value: str, into: str, number: int
) -> None:
    written = (
        f"duration: 3\nbase_rate: 1\ncomponents:\n"
        f"  a: {{fmu: {source(tmp_path, kind, value)}, rate: 1}}\n"
        f"  f: {{fmu: {fmu_of(tmp_path, into)}, rate: 1}}\nconnections: [a.y -> f.u]\n"
    )
    with pytest.raises(RunError, match=rf"f\.u cannot take {number} at tick 1 .*type {into}"):
        run(scenario_of(tmp_path, written))


@pytest.mark.parametrize("value", ["1ULL << 63", "-1"])
def test_an_output_beyond_63_bits_is_refused_and_not_wrapped(tmp_path: Path, value: str) -> None:
    written = (
        f"duration: 3\nbase_rate: 1\ncomponents:\n"
        f"  a: {{fmu: {source(tmp_path, 'UInt64', value)}, rate: 1}}\nrecord: [a.y]\n"
    )
    number = 2**63 if value != "-1" else 2**64 - 1
    with pytest.raises(RunError, match=rf"a\.y became {number} at tick 1 .*up to {2**63 - 1}"):
        run(scenario_of(tmp_path, written))


def test_every_problem_is_told_at_once(tmp_path: Path) -> None:
    more = "    start:\n      u: 300\n    parameters:\n      p: -129\n"
    with pytest.raises(InputErrors, match=r"(?s)f\.u is of type.*f\.p is of type"):
        assemble(scenario_of(tmp_path, scenario_text(fmu_of(tmp_path, "Int8"), more)))


@pytest.mark.parametrize(("high", "rest"), [(0, 2**53 - 1), (0, -(2**53)), (1, 2**53 - 1)])
def test_a_whole_number_becomes_the_same_real_one_or_is_refused(
    tmp_path: Path, high: int, rest: int
) -> None:
    """A double holds each up to 2**53."""
    number = rest + 2 * high
    written = (
        f"duration: 3\nbase_rate: 1\ncomponents:\n"
        f"  a: {{fmu: {source(tmp_path, 'Int64', f'{rest}LL + {2 * high}')}, rate: 1}}\n"
        f"  f: {{fmu: {fmu_of(tmp_path, 'Float64')}, rate: 1}}\n"
        "connections: [a.y -> f.u]\nrecord: [f.u]\n"
    )
    if not high:
        sink, _ = run(scenario_of(tmp_path, written))
        assert int(sink.signal("f.u")[-1]) == number
        return
    with pytest.raises(RunError, match=rf"f\.u cannot be {number} at tick 1 .* up to {2**53}"):
        run(scenario_of(tmp_path, written))
