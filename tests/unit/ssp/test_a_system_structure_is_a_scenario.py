"""Hierarchy, transformations, units, parameter sets and mappings of SSP, as the standard says."""

from __future__ import annotations

import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import fmus
from cosim.base.document.yaml_writer import write_yaml
from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.ssp.package import is_system
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.ssp import (
    HEAD,
    PASS,
    PORTS,
    bindings,
    component,
    connect,
    connectors,
    read,
    ssd,
    values,
)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_nested_systems_are_resolved_whichever_way_a_connection_is_written(
    folder: Path, version: str
) -> None:
    inner = (
        '<System name="inner">'
        + connectors(into="input", out="output")
        + f"<Elements>{component('b')}</Elements><Connections>"
        + connect("b.u", "into", '<ssc:LinearTransformation factor="2" offset="1"/>')
        + connect("b.y", "out")
        + "</Connections></System>"
    )
    inside = (
        f"<Elements>{component('a')}{inner}{component('c')}</Elements><Connections>"
        + connect("inner.into", "a.y", '<ssc:LinearTransformation factor="3" offset="10"/>')
        + connect("inner.out", "c.u")
        + "</Connections>"
    )
    document, notes = read(ssd(folder, inside, version))
    assert notes == []
    assert list(document["components"]) == ["a", "inner_b", "c"]
    assert sorted(document["connections"], key=lambda each: each["to"]) == [
        {"from": "inner_b.y", "to": "c.u"},
        {"from": "a.y", "to": "inner_b.u", "factor": 6.0, "offset": 21.0},
    ]
    assert document["duration"] == "1"
    assert {part["rate"] for part in document["components"].values()} == {"8"}


def test_it_computes_what_the_transformations_say(folder: Path) -> None:
    inside = (
        f"<Elements>{component('a', bindings(values('p|2|')))}{component('b')}</Elements>"
        "<Connections>"
        + connect("a.y", "b.u", '<ssc:LinearTransformation factor="1.5" offset="-1"/>')
        + "</Connections>"
    )
    document, _ = read(ssd(folder, inside))
    file = folder / "s.yaml"
    file.write_text(write_yaml(document))
    sink = MemorySink()
    with assemble(load(file)) as simulation:
        simulation.run(sink)
    assert list(sink.signal("a.y"))[:3] == [0, 2, 2]
    assert list(sink.signal("b.y"))[:4] == [0, -1, 2, 2]


def test_later_bindings_win_and_outer_ones_over_inner_ones(folder: Path) -> None:
    own = bindings(values("p|1|", "u|5|"), values("p|2|"))
    inside = f"<Elements>{component('a', own)}{component('b')}</Elements>"
    document, _ = read(ssd(folder, inside))
    assert document["components"]["a"]["parameters"] == {"p": 2.0}
    assert document["components"]["a"]["start"] == {"u": 5.0}
    outer = connectors(q="parameter") + inside
    outer += "<Connections>" + connect("q", "b.p", '<ssc:LinearTransformation factor="10"/>')
    outer += "</Connections>"
    bound = bindings(values("a.p|3|", "q|4|"))
    # The schema's order: connectors, bindings, elements, connections.
    head, tail = outer.split("</Connectors>", 1)
    document, _ = read(ssd(folder, f"{head}</Connectors>{bound}{tail}"))
    assert document["components"]["a"]["parameters"] == {"p": 3.0}
    assert document["components"]["b"]["parameters"] == {"p": 40.0}


def test_units_prefixes_and_mappings_of_parameter_sets(folder: Path) -> None:
    entry = '<ssm:MappingEntry source="length" target="p"><ssc:LinearTransformation factor="2"/>'
    mapping = (
        f'<ParameterMapping><ssm:ParameterMapping version="1.0">{entry}</ssm:MappingEntry>'
        "</ssm:ParameterMapping></ParameterMapping>"
    )
    mapped = values('length|10| unit="inch"', "p|9|", mapping=mapping)
    inside = (
        bindings(values('p|100| unit="inch"', prefix="b."), values("nobody|1|"))
        + f"<Elements>{component('a', bindings(mapped))}{component('b')}</Elements>"
    )
    document, notes = read(ssd(folder, inside))
    assert document["components"]["a"]["parameters"]["p"] == pytest.approx(0.508)
    assert document["components"]["b"]["parameters"]["p"] == pytest.approx(2.54)
    assert notes == ["nothing in root has the parameter nobody"]


def test_sets_and_mappings_lie_in_files_as_well(folder: Path) -> None:
    inner = values("p|7|").split("<ParameterValues>")[1].split("</ParameterValues>")[0]
    names = HEAD.format(version="1.0").split("xmlns:", 1)[1].rstrip(">")
    named = inner.replace("<ssv:ParameterSet", f"<ssv:ParameterSet xmlns:{names}", 1)
    (folder / "set.ssv").write_text(named)
    bound = bindings('<ParameterBinding source="set.ssv"/>')
    inside = f"<Elements>{component('a', bound)}</Elements>"
    document, _ = read(ssd(folder, inside))
    assert document["components"]["a"]["parameters"] == {"p": 7.0}
    missing = inside.replace("set.ssv", "none.ssv")
    with pytest.raises(InputError, match=r"SystemStructure\.ssd:1:1: there is no none\.ssv"):
        read(ssd(folder, missing))


IN_MM = (
    '<Connectors><Connector name="{name}" kind="{kind}"><ssc:Real unit="mm"/></Connector>'
    "</Connectors>"
)
MM = '<Units><ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit></Units>'


def with_units(file: Path) -> Path:
    """The same structure, which defines millimetres."""
    text = file.read_text().replace("<DefaultExperiment", f"{MM}<DefaultExperiment")
    file.write_text(text)
    return file


def test_a_transformation_is_in_the_unit_of_its_connector(folder: Path) -> None:
    """In millimetres there are 10 on the way; then what is left is doubled, and 1 m more."""
    inner = (
        '<System name="inner">'
        + IN_MM.format(name="into", kind="input")
        + f"<Elements>{component('b')}</Elements><Connections>"
        + connect("into", "b.u", '<ssc:LinearTransformation factor="2" offset="1"/>')
        + "</Connections></System>"
    )
    inside = (
        f"<Elements>{component('a', bindings(values('p|5|')))}{inner}</Elements><Connections>"
        + connect("a.y", "inner.into", '<ssc:LinearTransformation factor="3" offset="10"/>')
        + "</Connections>"
    )
    document, notes = read(with_units(ssd(folder, inside, "2.0")))
    assert notes == []
    (connection,) = document["connections"]
    assert connection == {"from": "a.y", "to": "inner_b.u", "factor": 6.0, "offset": 1.02}
    assert heard(folder, document) == pytest.approx(6 * 5 + 1.02)


def heard(folder: Path, document: dict[str, Any]) -> float:
    """The input of the last component at the end of a run."""
    (folder / "s.yaml").write_text(write_yaml(document))
    sink = MemorySink()
    with assemble(load(folder / "s.yaml")) as simulation:
        simulation.run(sink)
    return float(sink.signal(document["connections"][0]["to"])[-1])


def bare(folder: Path) -> str:
    """A component whose FMU has no units, and whose connectors are in millimetres."""
    foreign_fmu(
        folder,
        3,
        scalar(3, "y", 1, causality="output")
        + scalar(3, "u", 2, causality="input", start="0")
        + scalar(3, "p", 3, causality="parameter", variability="fixed", start="0"),
        structure='<Output valueReference="1" dependencies=""/>',
        before='<DefaultExperiment stepSize="0.125"/>',
        snippet=PASS,
        name="bare",
    )
    ports = PORTS.replace('unit="m"', 'unit="mm"')
    inside = bindings(values("p|3|"))
    return f'<Component name="bare" source="bare.fmu">{ports}{inside}</Component>'


def test_a_connector_says_the_unit_where_its_fmu_does_not(folder: Path) -> None:
    inside = f"<Elements>{bare(folder)}{component('b')}</Elements><Connections>{{}}</Connections>"
    file = with_units(ssd(folder, inside.format(connect("bare.y", "b.u")), "2.0"))
    document, notes = read(file)
    assert notes == []
    assert document["connections"] == [{"from": "bare.y", "to": "b.u", "factor": 0.001}]
    assert heard(folder, document) == pytest.approx(0.003)
    free = connect("bare.y", "b.u", more='suppressUnitConversion="true"')
    document, _ = read(with_units(ssd(folder, inside.format(free), "2.0")))
    assert document["connections"] == [{"from": "bare.y", "to": "b.u"}]


def test_a_connector_that_contradicts_its_fmu_is_noted(folder: Path) -> None:
    inside = f"<Elements>{component('a')}</Elements>".replace('unit="m"', 'unit="mm"')
    _, notes = read(with_units(ssd(folder, inside, "2.0")))
    assert len(notes) == 3
    assert "the connector a.y is in mm and its FMU's variable in m: the FMU's unit counts" in notes


def test_what_does_not_convert_on_the_way_is_refused_in_its_line(folder: Path) -> None:
    kilograms = IN_MM.replace('unit="mm"', 'unit="kg"').format(name="into", kind="input")
    inner = (
        f'<System name="inner">{kilograms}<Elements>{component("b")}</Elements><Connections>'
        + connect("into", "b.u")
        + "</Connections></System>"
    )
    inside = f"<Elements>{component('a')}{inner}</Elements><Connections>"
    with pytest.raises(InputError, match=r"ssd:1:1: .*it is in m, which does not convert to kg"):
        read(ssd(folder, f"{inside}{connect('a.y', 'inner.into')}</Connections>", "2.0"))


def test_a_parameter_passes_the_units_of_connectors(folder: Path) -> None:
    """4 inch are 101.6 mm in the system; ten times as many in the component, and 0.5 m more."""
    inside = (
        IN_MM.format(name="q", kind="parameter")
        + bindings(values('q|4| unit="inch"'))
        + f"<Elements>{component('b')}</Elements><Connections>"
        + connect("q", "b.p", '<ssc:LinearTransformation factor="10" offset="0.5"/>')
        + "</Connections>"
    )
    document, _ = read(with_units(ssd(folder, inside, "2.0")))
    assert document["components"]["b"]["parameters"]["p"] == pytest.approx(10 * 0.1016 + 0.5)


def test_a_mapping_transforms_behind_the_conversion_or_without_one(folder: Path) -> None:
    entry = (
        '<ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="length" '
        'target="p"{}><ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>'
        "</ssm:ParameterMapping></ParameterMapping>"
    )
    for more, value in (("", 2 * 0.254 + 1), (' suppressUnitConversion="true"', 21.0)):
        bound = bindings(values('length|10| unit="inch"', mapping=entry.format(more)))
        document, _ = read(ssd(folder, f"<Elements>{component('a', bound)}</Elements>"))
        assert document["components"]["a"]["parameters"]["p"] == pytest.approx(value)


@pytest.mark.parametrize("number", ["two", "INF", ""])
def test_what_is_no_number_is_refused_in_its_line(folder: Path, number: str) -> None:
    moved = f'<ssc:LinearTransformation factor="{number}"/>'
    inside = (
        f"<Elements>{component('a')}{component('b')}</Elements>"
        f"<Connections>{connect('a.y', 'b.u', moved)}</Connections>"
    )
    with pytest.raises(InputError, match=rf"ssd:1:1: the factor '{number}' is no number"):
        read(ssd(folder, inside))
    units = MM.replace("0.001", number)
    file = ssd(folder, f"<Elements>{component('a')}</Elements>", "2.0")
    file.write_text(file.read_text().replace("<DefaultExperiment", f"{units}<DefaultExperiment"))
    with pytest.raises(InputError, match=rf"the factor '{number}' is no number"):
        read(file)


def test_suppressed_conversions_and_steps_of_osp_are_obeyed(folder: Path) -> None:
    hint = (
        '<Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:StepSizeHint '
        'xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations" value="0.25"/>'
        "</ssc:Annotation></Annotations>"
    )
    inside = (
        f"<Elements>{component('a', hint)}{component('b')}</Elements><Connections>"
        + connect("a.y", "b.u", more='suppressUnitConversion="true"')
        + "</Connections>"
    )
    document, _ = read(ssd(folder, inside))
    # Both are in m: there is nothing to ignore.
    assert document["connections"] == [{"from": "a.y", "to": "b.u"}]
    assert document["components"]["a"]["rate"] == "4"


REFUSED = {
    "signal dictionary 'bus' cannot be used": (
        "<Elements><SignalDictionaryReference name='bus' dictionary='d'/></Elements>"
    ),
    "has no element 'b'": (
        f"<Elements>{component('a')}</Elements><Connections>{connect('a.y', 'b.u')}</Connections>"
    ),
    "both ends of the connection .* give values": (
        f"<Elements>{component('a')}{component('b')}</Elements>"
        f"<Connections>{connect('a.y', 'b.y')}</Connections>"
    ),
    "b.u is driven twice": (
        f"<Elements>{component('a')}{component('b')}</Elements>"
        f"<Connections>{connect('a.y', 'b.u')}{connect('b.u', 'b.y')}</Connections>"
    ),
    "is for ModelExchange": (
        "<Elements><Component name='a' source='adder.fmu' implementation='ModelExchange'/>"
        "</Elements>"
    ),
    "of type application/x-ssp-package": (
        "<Elements><Component name='a' source='x.ssp' type='application/x-ssp-package'/></Elements>"
    ),
    "there is no .*none.fmu": "<Elements><Component name='a' source='none.fmu'/></Elements>",
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_cannot_be_used_is_refused_by_its_name(folder: Path, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(ssd(folder, REFUSED[said]))


def test_what_the_schema_finds_wrong_is_a_note(folder: Path) -> None:
    file = ssd(folder, f"<Elements>{component('a')}</Elements>")
    file.write_text(file.read_text().replace('name="root"', 'name="root" colour="red"'))
    _, notes = read(file)
    assert len(notes) == 1
    assert "'colour' is not allowed" in notes[0]


def test_no_file_gives_a_traceback(tmp_path: Path) -> None:
    for name, content in (("a.ssd", b"<"), ("b.ssd", b"<x/>"), ("c.ssp", b"no zip")):
        (tmp_path / name).write_bytes(content)
        assert is_system(str(tmp_path / name))
        with pytest.raises(InputError):
            read(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "d.ssp", "w") as archive:
        archive.writestr("other.ssd", "<x/>")
    with pytest.raises(InputError, match=r"has no SystemStructure\.ssd at its top"):
        read(tmp_path / "d.ssp")
    with pytest.raises(InputError, match="there is no file"):
        read(tmp_path / "none.ssp")
    assert not is_system(str(fmus.find("hand")))


OSP = """<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure"
    version="0.1"><StartTime>0</StartTime><BaseStepSize>0.25</BaseStepSize>
    <Simulators><Simulator name="a" source="adder.fmu" stepSize="0.125"><InitialValues>
    <InitialValue variable="p"><Real value="2"/></InitialValue></InitialValues></Simulator>
    <Simulator name="b" source="adder.fmu"/></Simulators>
    <Functions><{function} name="f" factor="3" offset="4" inputCount="1"/></Functions>
    <Connections><SignalConnection><Variable simulator="a" name="y"/>
    <Signal function="f" name="in"/></SignalConnection><SignalConnection>
    <Signal function="f" name="out"/><Variable simulator="b" name="u"/></SignalConnection>
    </Connections></OspSystemStructure>"""


def test_an_osp_system_structure_is_read(folder: Path) -> None:
    file = folder / "OspSystemStructure.xml"
    file.write_text(OSP.replace("{function}", "LinearTransformation"))
    document, _ = read(file, Fraction(2))
    assert document["duration"] == "2"
    assert [part["rate"] for part in document["components"].values()] == ["8", "4"]
    assert document["components"]["a"]["parameters"] == {"p": 2.0}
    (connection,) = document["connections"]
    assert connection == {
        "from": "a.y", "to": "b.u", "factor": 3.0, "offset": 4.0,
    }  # fmt: skip
    with pytest.raises(InputError, match="does not say how long to run"):
        read(file)
    file.write_text(OSP.replace("{function}", "Sum"))
    with pytest.raises(InputError, match="a Sum 'f' cannot be used here"):
        read(file, Fraction(2))


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ('<Real value="2"/>', '<Real value="two"/>', "'two' is no Real"),
        ('stepSize="0.125"', 'stepSize="0"', "the step of a is '0', which is no time above 0"),
        ('stepSize="0.125"', 'stepSize="x"', "the step of a is 'x', which is no time above 0"),
        ('factor="3"', 'factor="x"', "the factor 'x' is no number"),
    ],
)
def test_what_is_no_number_of_osp_is_refused(
    folder: Path, right: str, wrong: str, said: str
) -> None:
    file = folder / "OspSystemStructure.xml"
    assert right in OSP
    file.write_text(OSP.replace("{function}", "LinearTransformation").replace(right, wrong))
    with pytest.raises(InputError, match=said):
        read(file, Fraction(2))


def test_an_fmu_that_is_none_is_refused_in_osp_too(folder: Path) -> None:
    file = folder / "OspSystemStructure.xml"
    file.write_text(OSP.replace("{function}", "LinearTransformation"))
    (folder / "adder.fmu").write_bytes(b"no zip")
    with pytest.raises(InputError, match=r"adder\.fmu"):
        read(file, Fraction(2))


@pytest.mark.parametrize(
    ("start", "stop", "duration"), [("0.25", None, "0.75"), ("-1", None, "2"), ("0.5", 3, "2.5")]
)
def test_time_begins_where_the_system_says(
    folder: Path, start: str, stop: int | None, duration: str
) -> None:
    file = ssd(folder, f"<Elements>{component('a')}</Elements>", start=start)
    document, notes = read(file, None if stop is None else Fraction(stop))
    assert notes == []
    assert (document["start_time"], document["duration"]) == (start, duration)


@pytest.mark.parametrize(
    ("start", "stop", "sentence"),
    [("2", None, "begins at 2 s and would stop at 1 s"), ("INF", 1, "is INF, which is no time")],
)
def test_a_time_that_cannot_be_is_refused(
    folder: Path, start: str, stop: int | None, sentence: str
) -> None:
    file = ssd(folder, f"<Elements>{component('a')}</Elements>", start=start)
    with pytest.raises(InputError, match=sentence):
        read(file, None if stop is None else Fraction(stop))
