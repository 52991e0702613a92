"""What a system structure says is used, noted or refused in its line; nothing of it is passed over.

Of SSP and of OSP, with files that no tool of the house would write.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.cli.ssp.system import scenario_of_system
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.ssp.package import read_system
from tests.support.ssp import (
    PORTS,
    bindings,
    component,
    connect,
    read,
    ssd,
    values,
)


def system(connections: str, a: str = "", own: str = "") -> str:
    parts = component("a", a) + component("b")
    return f"<Elements>{parts}</Elements><Connections>{connections}</Connections>{own}"


WAY = connect("a.y", "b.u")
OWN = (
    '<Annotations><ssc:Annotation type="org.cohaptic"><c:Scenario '
    'xmlns:c="https://cohaptic.org/ssp">{0}</c:Scenario></ssc:Annotation></Annotations>'
)
ENDLESS = ("1e999999999", "1e400", "1e-999999999", "1/0", "NaN", "")


@pytest.mark.parametrize("time", ENDLESS)
@pytest.mark.parametrize("which", ["startTime", "stopTime"])
def test_a_time_that_is_none_ends_in_a_sentence(folder: Path, which: str, time: str) -> None:
    """The exact value of ``1e999999999`` fills any memory."""
    file = ssd(folder, system(WAY))
    good = {"startTime": '"0"', "stopTime": '"1"'}[which]
    file.write_text(file.read_text().replace(f"{which}={good}", f'{which}="{time}"'))
    with pytest.raises(InputError, match=f"the {which} of SystemStructure.ssd is {time}, which is"):
        read(file)


@pytest.mark.parametrize("value", ["NaN", "INF", "1e999", "x", "", "1 x"])
def test_a_value_that_is_no_number_is_refused_in_its_line(folder: Path, value: str) -> None:
    file = ssd(folder, system(WAY, bindings(values(f"p|{value}|"))))
    with pytest.raises(InputError, match=rf"SystemStructure.ssd:1:1: '{value}' is no Real"):
        read(file)


@pytest.mark.parametrize(("right", "wrong"), [("0.0254", "0"), ('m="1"', 'm="1.5"')])
def test_a_unit_that_nothing_converts_to_is_refused(folder: Path, right: str, wrong: str) -> None:
    given = values("p|1| unit='inch'")
    file = ssd(folder, system(WAY, bindings(given.replace(right, wrong))))
    with pytest.raises(InputError, match="nothing converts to the unit inch"):
        read(file)


MAPPING = (
    '<ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="nothing" '
    'target="p"/></ssm:ParameterMapping></ParameterMapping>'
)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (values("p|1|", "p|2|"), ["p is given twice; the last value counts"]),
        (values("p|1|", mapping=MAPPING), ["no parameter 'nothing' is given to be mapped"]),
        (values("p|1| unit='blorp'"), ["a.p: nobody says what blorp measures, so its number is"]),
        (values("y|1|"), ["a.y is calculated by its FMU, so the value that is given for it is"]),
        (values("z|1|"), ["a parameter set: a has no variable 'z'"]),
        (values("p|1|"), []),
    ],
)
def test_a_value_that_is_not_used_as_it_is_written_is_noted(
    folder: Path, given: str, said: list[str]
) -> None:
    _, notes = read(ssd(folder, system(WAY, bindings(given))))
    assert len(notes) == len(said)
    assert all(sentence in note for sentence, note in zip(said, notes, strict=True)), notes


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        (
            '<Connector name="p"',
            '<Connector name="ghost" kind="output"><ssc:Real/></Connector><Connector name="p"',
            "the connector a.ghost is of nothing that its FMU has",
        ),
        (
            'name="p" kind="parameter"',
            'name="p" kind="input"',
            "the connector a.p is written as of kind input; its FMU's variable is of causality p",
        ),
        (
            '<ssc:Real unit="m"/></Connector></Connectors>',
            "<ssc:Integer/></Connector></Connectors>",
            "the connector a.p is written as Integer; its FMU's variable is of type Float64",
        ),
    ],
)
def test_a_connector_that_is_not_its_fmus_is_noted(
    folder: Path, right: str, wrong: str, said: str
) -> None:
    text = system(WAY).replace(PORTS, PORTS.replace(right, wrong), 1)
    assert wrong in text
    _, notes = read(ssd(folder, text))
    assert len(notes) == 1
    assert notes[0].startswith(said)


@pytest.mark.parametrize(
    ("connection", "said"),
    [
        (connect("a.y", "b.z"), "b has no variable 'z'"),
        (connect("a.z", "b.u"), "a has no variable 'z'"),
        (connect("a.y", "c.u"), "has no element 'c'"),
        (connect("a.y", "z"), "the system 'root' has no connector 'z'"),
    ],
)
def test_a_connection_to_nothing_names_it(folder: Path, connection: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(ssd(folder, system(connection)))


@pytest.mark.parametrize("own", ["components: [1]", "connections: {a: 1}", "components: 3"])
def test_an_annotation_that_only_looks_like_ours_is_refused(folder: Path, own: str) -> None:
    text = OWN.format(own) + system(WAY)
    with pytest.raises(InputError, match="has components that are no mapping, or connections"):
        read(ssd(folder, text))


@pytest.mark.parametrize(
    ("name", "plain"), [("Größe", "Gro_e"), ("a b", "a_b"), ("7", "component"), ("é.b", "e_b")]
)
def test_an_element_has_a_name_of_the_scenario(folder: Path, name: str, plain: str) -> None:
    from cosim.base.document.yaml_writer import write_yaml

    parts = component(name, bindings(values("p|3|"))) + component("b")
    way = connect(f"{name}.y", "b.u")
    file = ssd(folder, f"<Elements>{parts}</Elements><Connections>{way}</Connections>")
    document, _ = read(file)
    assert list(document["components"]) == [plain, "b"]
    written = folder / "it.yaml"
    written.write_text(write_yaml(document))
    assemble(load(written)).close()


def test_a_name_with_a_dot_is_not_taken_for_a_member(folder: Path) -> None:
    parts = component("a") + component("a.b")
    given = bindings(values("a.b.p|2|", "a.p|1|"))
    document, notes = read(ssd(folder, f"{given}<Elements>{parts}</Elements>"))
    assert notes == []
    assert [each["parameters"]["p"] for each in document["components"].values()] == [1, 2]


def run_of(file: Path, stop: str | None, *sets: str) -> tuple[tuple[float, float], str, list[str]]:
    """From when to when (s), under which name, and what is said."""
    said: list[str] = []
    scenario = scenario_of_system(str(file), stop_time=stop, sets=sets, say=said.append)
    start, end = scenario.start_time, scenario.ticks / scenario.base_rate
    return (float(start), float(start + end)), scenario.name, said


@pytest.mark.parametrize(
    ("own", "stop", "sets", "times"),
    [
        ("", None, (), (0.5, 1)),
        ("", "3", (), (0.5, 3)),
        ("", None, ("start_time=0.25",), (0.25, 1)),
        ("", "3", ("start_time = 1 s",), (1, 3)),
        ("start_time: 2\nduration: 4", None, (), (2, 6)),
        ("start_time: 2\nduration: 4", "3", (), (2, 3)),
        ("start_time: 2\nduration: 4", "3", ("start_time=1",), (1, 3)),
    ],
)
def test_it_begins_and_ends_when_it_is_said(
    folder: Path, own: str, stop: str | None, sets: tuple[str, ...], times: tuple[float, float]
) -> None:
    text = (OWN.format(own) if own else "") + system(WAY)
    file = ssd(folder, text, start="0.5")
    assert run_of(file, stop, *sets)[0] == times


def test_a_part_of_a_tick_is_run_to_its_end_and_said(folder: Path) -> None:
    file = ssd(folder, system(WAY))
    assert run_of(file, "0.2")[::2] == (
        (0, 0.25),
        ["note: 0.2 s are no whole number of ticks; the run ends at 0.25 s"],
    )


def test_a_time_to_begin_that_is_none_is_refused(folder: Path) -> None:
    with pytest.raises(InputError, match="--set start_time=soon: 'soon' is not a number"):
        run_of(ssd(folder, system(WAY)), None, "start_time=soon")
    with pytest.raises(InputError, match=r"annotation of .* has the start_time \[1\]"):
        run_of(ssd(folder, OWN.format("start_time: [1]") + system(WAY)), None)


@pytest.mark.parametrize(("name", "plain"), [("31-a", "a"), ("größe", "gro_e"), ("1", "system")])
def test_a_folder_is_called_as_it_likes(folder: Path, name: str, plain: str) -> None:
    ssd(folder, system(WAY))
    assert run_of(folder.rename(folder.with_name(name)), None)[1] == plain


SIMULATOR = '<Simulator name="b" source="adder.fmu"/>'
START = (
    '<Simulator name="a" source="adder.fmu"><InitialValues><InitialValue variable="p">'
    '<Real value="2"/></InitialValue></InitialValues></Simulator>'
)
JOIN = (
    '<VariableConnection><Variable simulator="a" name="y"/><Variable simulator="b" name="u"/>'
    "</VariableConnection>"
)
INTO = (
    '<SignalConnection><Variable simulator="a" name="y"/><Signal function="f" name="in"/>'
    "</SignalConnection>"
)
OUT = (
    '<SignalConnection><Signal function="f" name="out"/><Variable simulator="b" name="u"/>'
    "</SignalConnection>"
)


def osp(folder: Path, right: str = "", wrong: str = "", connections: str = INTO + OUT) -> Path:
    text = (
        '<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" '
        'version="0.1"><StartTime>0</StartTime><EndTime>1</EndTime><BaseStepSize>0.125'
        f"</BaseStepSize><Algorithm>fixedStep</Algorithm><Simulators>{START}{SIMULATOR}"
        '</Simulators><Functions><LinearTransformation name="f" factor="3" offset="4"/>'
        f"</Functions><Connections>{connections}</Connections></OspSystemStructure>"
    )
    assert right in text
    file = folder / "OspSystemStructure.xml"
    file.write_text(text.replace(right, wrong))
    return file


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ('<Real value="2"/>', '<Real value="NaN"/>', "'NaN' is no Real"),
        ('<Real value="2"/>', '<Boolean value="yes"/>', "'yes' is no Boolean"),
        ('<Real value="2"/>', '<Integer value="2.5"/>', "'2.5' is no Integer"),
        ('<Real value="2"/>', '<Float64 value="2"/>', "of type Float64 cannot be given"),
        ('<Real value="2"/>', "", "the initial value of 'p' is not one"),
        (SIMULATOR, SIMULATOR * 2, "there are two simulators 'b'"),
        (SIMULATOR, '<Simulator name="b"/>', "a simulator has a name and a source"),
        (OUT, "", "the function 'f': nothing takes what it gives"),
        (INTO, "", "the function 'f': nothing drives it"),
        (INTO, INTO + INTO.replace('"y"', '"u"'), "the function 'f' is driven twice"),
        ('name="out"', 'name="ouput"', "the function 'f' has no signal 'ouput'"),
        ('function="f" name="in"', 'function="g" name="in"', "there is no function 'g'"),
        ('<Variable simulator="b" name="u"/>', "", "a SignalConnection has two ends, not 1"),
    ],
)
def test_what_osp_leaves_open_is_refused(folder: Path, right: str, wrong: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_system(osp(folder, right, wrong), None)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("fixedStep", "ecco", ["the algorithm ecco is not known here"]),
        (
            "</InitialValues>",
            '<InitialValue variable="p"><Real value="4"/></InitialValue></InitialValues>',
            ["p is given twice; the last value counts"],
        ),
        ('variable="p"', 'variable="y"', ["a.y is calculated by its FMU"]),
        ('source="adder.fmu"', 'source="%61dder%2Efmu"', []),
    ],
)
def test_what_osp_says_and_is_not_done_is_noted(
    folder: Path, right: str, wrong: str, said: list[str]
) -> None:
    document, notes = read_system(osp(folder, right, wrong), None)
    assert [sentence in note for sentence, note in zip(said, notes, strict=True)] == [
        True for _ in said
    ]
    assert [each["to"] for each in document["connections"]] == ["b.u"]


@pytest.mark.parametrize("number", [1, 3])
def test_a_join_of_osp_has_two_ends(folder: Path, number: int) -> None:
    end = '<Variable simulator="a" name="y"/>'
    join = f"<VariableConnection>{end * number}</VariableConnection>"
    with pytest.raises(InputError, match=f"a VariableConnection has two ends, not {number}"):
        read_system(osp(folder, connections=join), None)
    assert read_system(osp(folder, connections=JOIN), None)[1] == []
