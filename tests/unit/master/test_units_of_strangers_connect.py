"""Units that only an FMU knows: usable in the scenario, over connections noted or ignored."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import Simulation, assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

UNITS = (
    '<UnitDefinitions><Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="100000"/></Unit>'
    '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="K"><BaseUnit K="1"/></Unit><Unit name="blips"/>'
    '<Unit name="m"><BaseUnit m="1"/></Unit><Unit name="mm"/>'
    "</UnitDefinitions>"
)
STRUCTURE = {
    2: '<Outputs><Unknown index="1" dependencies=""/></Outputs>',
    3: '<Output valueReference="1" dependencies=""/>',
}


def fmu(folder: Path, version: int, name: str, unit: str, more: str = "") -> Path:
    y = {"causality": "output", "initial": "exact", "start": "0"}
    variables = scalar(version, "y", 1, unit=unit, **y)
    variables += scalar(version, "u", 2, causality="input", start="0", unit=unit)
    structure = STRUCTURE[version]
    return foreign_fmu(
        folder, version, variables + more, before=UNITS, name=name, structure=structure
    )


def joined(folder: Path, version: int, units: tuple[str, str], more: str = "") -> Simulation:
    first = fmu(folder, version, "first", units[0])
    second = fmu(folder, version, "second", units[1])
    return assemble(
        scenario_of(
            folder,
            f"duration: 1\ncomponents:\n  a: {{fmu: {first}, rate: 10, start: {{y: 2}}}}\n"
            f"  b: {{fmu: {second}, rate: 10}}\nconnections: [{{from: a.y, to: b.u{more}}}]\n",
        )
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [
        ("20 degC", "degC", 20),
        ("20 degC", "K", 293.15),
        ("2 bar", "bar", 2),
        ("3 blips", "blips", 3),
        ("200 kPa", "bar", 2),
    ],
)
def test_a_scenario_may_use_the_fmus_own_units(
    tmp_path: Path, version: int, written: str, unit: str, value: float
) -> None:
    more = scalar(
        version, "p", 3, causality="parameter", variability="tunable", unit=unit, start="0"
    )
    path = fmu(tmp_path, version, "it", "1", more)
    text = (
        f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10, "
        f"parameters: {{p: {written}}}}}}}\n"
    )
    simulation = assemble(scenario_of(tmp_path, text))
    assert simulation.assembly.participants["it"].parameters["p"] == [pytest.approx(value)]


def test_a_pascal_is_given_in_bar_where_the_fmu_says_what_that_is(tmp_path: Path) -> None:
    more = scalar(3, "p", 3, causality="parameter", variability="fixed", unit="Pa", start="0")
    path = fmu(tmp_path, 3, "it", "1", more)
    text = f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10, parameters: {{p: 2 bar}}}}}}\n"
    simulation = assemble(scenario_of(tmp_path, text))
    assert simulation.assembly.participants["it"].parameters["p"] == [200000.0]


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_that_is_only_a_name_is_read_as_one_or_connects_with_a_note(
    tmp_path: Path, version: int
) -> None:
    with joined(tmp_path, version, ("mm", "m")) as simulation:
        assert simulation.notes == ("a.y -> b.u: mm is converted to m",)
    with joined(tmp_path, version, ("blips", "m")) as simulation:
        (note,) = simulation.notes
        assert "nobody says what blips measures" in note
        simulation.run()
        assert simulation.program.view("b", "u")[0] == 2.0


def test_unit_ignore_passes_the_number_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unit: ignore"):
        joined(tmp_path, 3, ("bar", "m"))
    for units in (("bar", "m"), ("K", "degC"), ("blips", "m")):
        with joined(tmp_path, 3, units, ", unit: ignore") as simulation:
            assert simulation.notes == ()
            simulation.run()
            assert simulation.program.view("b", "u")[0] == 2.0
    with pytest.raises(InputError, match="agree; leave 'unit' out"):
        joined(tmp_path, 3, ("m", "m"), ", unit: ignore")


def test_it_is_written_back(tmp_path: Path) -> None:
    from cosim.scenario.resolved import to_document

    with joined(tmp_path, 3, ("bar", "m"), ", unit: ignore") as simulation:
        (written,) = to_document(simulation.scenario)["connections"]
    assert written == {"from": "a.y", "to": "b.u", "unit": "ignore"}


def test_a_difference_given_in_another_unit_has_no_offset_either(tmp_path: Path) -> None:
    kelvin = {"causality": "parameter", "variability": "fixed", "unit": "K", "start": "0"}
    more = scalar(3, "p", 3, **kelvin, relativeQuantity="true")
    path = fmu(tmp_path, 3, "it", "1", more)
    text = (
        f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10, parameters: {{p: 5 degC}}}}}}\n"
    )
    _, simulation = run(scenario_of(tmp_path, text))
    assert simulation.assembly.participants["it"].parameters["p"] == [5.0]


def items(*names: str) -> str:
    inner = "".join(f'<Item name="{n}" value="{i}"/>' for i, n in enumerate(names, 1))
    return f'<EnumerationType name="C">{inner}</EnumerationType>'


@pytest.mark.parametrize(
    ("there", "here", "said"),
    [
        (("red", "green"), ("red", "green"), []),
        (("red",), ("red", "green"), []),
        (("red", "green"), ("green", "red"), ["1 is red at one end and green at the other"]),
    ],
)
def test_numbers_with_other_names_at_the_other_end_are_noted(
    tmp_path: Path, there: tuple[str, ...], here: tuple[str, ...], said: list[str]
) -> None:
    kind = {"declaredType": "C", "start": "1", "initial": "exact", "variability": "discrete"}
    parts = {
        "a": (scalar(3, "y", 1, "Enumeration", causality="output", **kind), there, STRUCTURE[3]),
        "b": (scalar(3, "u", 1, "Enumeration", causality="input", **kind), here, ""),
    }
    paths = {
        name: foreign_fmu(
            tmp_path,
            3,
            variables.replace('initial="exact" ', "") if name == "b" else variables,
            before=f"<TypeDefinitions>{items(*names)}</TypeDefinitions>",
            structure=structure,
            name=name,
        )
        for name, (variables, names, structure) in parts.items()
    }
    written = "".join(f"  {name}: {{fmu: {path}, rate: 10}}\n" for name, path in paths.items())
    text = f"duration: 1\ncomponents:\n{written}connections: [a.y -> b.u]\n"
    with assemble(scenario_of(tmp_path, text)) as simulation:
        assert [note.partition("b.u: ")[2] for note in simulation.notes] == said
