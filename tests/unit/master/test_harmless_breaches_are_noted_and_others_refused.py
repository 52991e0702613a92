"""Which rules of the standard a description may break, and which not, each by name.

Harmless ones run with a note where the scenario is lenient, as it is unless it says otherwise;
where a variable would be another one, or none, nobody runs it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.imperfect import TIME, Break, broken_fmu
from tests.support.master.master_support import run, scenario_of

P2, P3 = (
    '<Real start="1"/>',
    '<Float64 name="p" valueReference="3" causality="parameter" variability="fixed" start="1"',
)
TIMES = '<DefaultExperiment startTime="0" stopTime="1"/>'
LOG = '<LogCategories><Category name="logAll"/></LogCategories>'
OUTPUT = '<Output valueReference="2" dependencies="1" dependenciesKind="dependent"/>'
UNKNOWN = '<InitialUnknown valueReference="2" dependencies="1"/>'
CAN = 'canHandleVariableCommunicationStepSize="true"'

HARMLESS = {
    "an attribute of the root": Break(2, 'guid="0"', 'guid="0" colour="red"', "'colour'"),
    "an attribute of a namespace": Break(
        3, 'Token="0"', 'Token="0" xmlns:v="urn:v" v:colour="red"', "'{urn:v}colour'"
    ),
    "an attribute of the interface": Break(2, CAN, CAN + ' canSing="true"', "'canSing'"),
    "an attribute of a variable": Break(2, 'name="n"', 'name="n" colour="red"', "'colour'"),
    "an attribute of a base unit": Break(
        2, '<BaseUnit m="1"/>', '<BaseUnit m="1" furlong="2"/>', "'furlong'"
    ),
    "an element that is unknown": Break(3, "<LogCategories>", "<Vendor/><LogCategories>", "Vendor"),
    "elements in another order": Break(2, f"{LOG}\n{TIMES}", TIMES + LOG, "LogCategories"),
    "an element that is there twice": Break(2, TIMES, TIMES * 2, "'DefaultExperiment'"),
    "a list of nothing": Break(2, '<Category name="logAll"/>', "", "'LogCategories'"),
    "no units in the list": Break(
        3, '<Unit name="m"><BaseUnit m="1"/></Unit>', "", "'UnitDefinitions'"
    ),
    "text between elements": Break(2, "<LogCategories>", "so<LogCategories>", "Character content"),
    "no name of the model": Break(2, ' modelName="foreign"', "", "'modelName' is required"),
    "a date that is none": Break(
        2, 'guid="0"', 'guid="0" generationDateAndTime="yesterday"', "'yesterday'"
    ),
    "a convention that is unknown": Break(
        2, 'guid="0"', 'guid="0" variableNamingConvention="free"', "'free'"
    ),
    "yes for true": Break(2, CAN, CAN.replace("true", "yes"), "'yes'"),
    "an input without a start": Break(2, 'start="0" declared', "declared", '"u" (line'),
    "a parameter without a start": Break(2, P2, "<Real/>", '"p" (line'),
    "a start of what is calculated": Break(
        2, '<Real unit="m"/>', '<Real unit="m" start="0"/>', 'initial="calculated" but'
    ),
    "an initial that is unknown": Break(
        2, 'initial="calculated"><Integer/>', 'initial="perhaps"><Integer/>', "'perhaps'"
    ),
    "a whole number that is continuous": Break(
        2, 'local" variability="discrete"', 'local" variability="continuous"', "of type Integer"
    ),
    "a parameter that is continuous": Break(
        2,
        'name="p" valueReference="3" causality="parameter" variability="fixed"',
        'name="p" valueReference="3" causality="parameter" variability="continuous"',
        'variability="continuous" in variable "p"',
    ),
    "a kind of dependency that is unknown": Break(2, '"dependent"', '"maybe"', "'maybe'"),
    "a unit that is not defined": Break(2, '<Real unit="m"/>', '<Real unit="furlong"/>', "furlong"),
    "a unit that is defined twice": Break(
        2,
        "</UnitDefinitions>",
        '<Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>',
        "the unit m is defined twice",
    ),
    "an enumeration without a type": Break(
        2, ' declaredType="Colour"', "", "'declaredType' is required"
    ),
    "no independent variable": Break(3, TIME, "", "Exactly one independent variable"),
    "a second independent variable": Break(
        3,
        TIME,
        TIME + TIME.replace("time", "later").replace("63", "62"),
        "Exactly one independent variable",
    ),
    "a reference that two types share": Break(
        3, 'name="n" valueReference="4"', 'name="n" valueReference="3"', "same value reference"
    ),
    "an annotation of nobody": Break(
        3,
        f"{P3}/>",
        f"{P3}><Annotations><Annotation>x</Annotation></Annotations></Float64>",
        "'type' is required",
    ),
    "unknowns in another order": Break(
        3, f"{OUTPUT}\n{UNKNOWN}", UNKNOWN + OUTPUT, "Element 'Output'"
    ),
    "a start outside of the range": Break(3, f"{P3}/>", f'{P3} max="0"/>', "outside of its range"),
    "a start that is no item": Break(
        3, 'fixed" start="1"\n', 'fixed" start="9"\n', 'start of "e" is none of Colour'
    ),
}

HARMFUL = {
    "no token of FMI 2": Break(2, ' guid="0"', "", "has no guid"),
    "no token of FMI 3": Break(3, ' instantiationToken="0"', "", "has no instantiationToken"),
    "no library": Break(2, 'modelIdentifier="foreign" ', "", "its library is called"),
    "a version that is unknown": Break(2, 'fmiVersion="2.0"', 'fmiVersion="2.1"', "version: 2.1"),
    "a type that is not defined": Break(2, '"Length"/', '"Breadth"/', '"Breadth"'),
    "a name that is there twice": Break(2, 'name="n"', 'name="u"', "declares u twice"),
    "a reference below 0": Break(2, 'Reference="4"', 'Reference="-4"', "valueReference is -4"),
    "a reference that is no number": Break(2, 'Reference="4"', 'Reference="four"', "'four'"),
    "no reference": Break(2, ' valueReference="4"', "", "number that the standard requires"),
    "a causality that is unknown": Break(2, '"local"', '"private"', "'private'"),
    "two types": Break(2, P2, P2 + '<Integer start="1"/>', "p is of Real and Integer"),
    "no type": Break(2, P2, "", "p is of no type"),
    "a start that is no number": Break(2, P2, '<Real start="one"/>', "its start, one"),
    "a limit that is no number": Break(
        2, P2, '<Real start="1" min="low"/>', "min, low, is no number"
    ),
    "a range without values": Break(3, f"{P3}/>", f'{P3} min="3" max="2"/>', "above its most"),
    "too many starts": Break(
        3,
        f"{P3}/>",
        f'{P3.replace("1", "1 2 3")}><Dimension start="2"/></Float64>',
        "3 starts for 2 elements",
    ),
    "a dimension of nothing": Break(3, f"{P3}/>", f"{P3}><Dimension/></Float64>", "neither"),
    "a type of another kind": Break(
        3, 'start="1"\n declaredType="Colour"', 'start="1"\n declaredType="Length"', "Length, is no"
    ),
    "two types of one name": Break(
        2,
        "</TypeDefinitions>",
        '<SimpleType name="Length"><Real/></SimpleType></TypeDefinitions>',
        "defines the type Length twice",
    ),
    "two items of one value": Break(2, '"blue" value="2"', '"blue" value="1"', "items of value 1"),
    "two items of one name": Break(2, '"blue" value="2"', '"red" value="2"', "items of name red"),
    "an output that is not there": Break(
        3, '<Output valueReference="2"', '<Output valueReference="77"', "valueReference 77"
    ),
    "an index that is not there": Break(
        2, '<Outputs><Unknown index="2"', '<Outputs><Unknown index="99"', "beyond the last"
    ),
    "a time that is no number": Break(2, 'stopTime="1"', 'stopTime="soon"', "stopTime"),
    "an end that is missing": Break(3, "</ModelStructure>", "", "tag mismatch"),
}


def scenario(fmu: Path, more: str = "") -> str:
    component = f"{{fmu: {fmu}, rate: 1{more}}}"
    return f"duration: 2\nbase_rate: 1\ncomponents:\n  f: {component}\nrecord: [f.u]\n"


def test_there_are_twenty_five_kinds() -> None:
    assert len(HARMLESS) >= 25
    assert len({(each.version, each.old, each.new) for each in HARMLESS.values()}) == len(HARMLESS)


@pytest.mark.parametrize("version", [2, 3])
def test_a_perfect_one_runs_without_a_note(version: int, tmp_path: Path) -> None:
    path = broken_fmu(tmp_path, None, version)
    _, simulation = run(scenario_of(tmp_path, scenario(path, ", validate: strict")))
    assert simulation.notes == ()


@pytest.mark.parametrize("kind", HARMLESS)
def test_a_harmless_breach_is_noted_and_strict_refuses_it(kind: str, tmp_path: Path) -> None:
    broken = HARMLESS[kind]
    path = broken_fmu(tmp_path, broken)
    sink, simulation = run(scenario_of(tmp_path, scenario(path)))
    assert sink.signal("f.u").tolist() == [0.0, 0.0]
    (note,) = simulation.notes
    assert note.startswith("f: its modelDescription.xml is not valid: ")
    assert broken.said in note
    with pytest.raises(InputError, match="is not valid"):
        assemble(scenario_of(tmp_path, scenario(path, ", validate: strict")))


@pytest.mark.parametrize("kind", HARMFUL)
def test_what_cannot_be_used_is_refused_by_name(kind: str, tmp_path: Path) -> None:
    broken = HARMFUL[kind]
    path = broken_fmu(tmp_path, broken)
    with pytest.raises(InputError) as caught:
        assemble(scenario_of(tmp_path, scenario(path)))
    assert broken.said in str(caught.value)
    assert str(path) in str(caught.value)
