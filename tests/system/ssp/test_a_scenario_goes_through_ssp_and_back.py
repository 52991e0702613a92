"""Every bundled scenario, written as SSP 2.0 and read again, computes the same bits."""

from __future__ import annotations

import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.analysis import load_tuned
from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.cli import cli
from cosim.cli.ssp.system import scenario_of_system
from cosim.master.run.simulation import assemble
from cosim.reading import FORMS
from cosim.scenario import Scenario, load
from cosim.scenario.source.find import bundled_folder, bundled_names
from cosim.ssp.documents import read_valid
from cosim.ssp.exporting import to_ssp
from tests.support.fmus.clocked import clocked_fmu
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

FOLDER = bundled_folder()
WHOLE = [name for name in bundled_names() if not name.startswith(("presets/", "devices/"))]
SECONDS = "0.25"


def rows(scenario: Scenario) -> tuple[list[str], list[np.ndarray]]:
    sink = MemorySink()
    with assemble(scenario) as simulation:
        simulation.run(sink)
    names = [column.name for group in sink.groups for column in group.columns]
    return names, [sink.rows(number) for number in range(len(sink.groups))]


def exported(scenario: Scenario, file: Path) -> Path:
    with assemble(scenario) as simulation:
        file.write_bytes(to_ssp(simulation.assembly))
    return file


def through_ssp(scenario: Scenario, file: Path) -> Scenario:
    notes: list[str] = []
    back = scenario_of_system(
        str(exported(scenario, file)), stop_time=None, sets=(), say=notes.append
    )
    assert notes == []
    return back


@pytest.mark.parametrize("name", ["two_users_box", "single_axis_centralized"])
@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_the_values_are_the_same_in_every_flavour(tmp_path: Path, name: str, flavour: str) -> None:
    sets = [f"duration={SECONDS}"]
    sets += [
        f"components.{part}.flavour={flavour}" for part in load(FOLDER / f"{name}.yaml").components
    ]
    scenario = load_tuned(name, sets=sets, forms=FORMS)
    names, here = rows(scenario)
    found, there = rows(through_ssp(scenario, tmp_path / "x.ssp"))
    assert found == names
    for one, other in zip(here, there, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", WHOLE)
def test_every_bundled_scenario_has_the_same_bits(tmp_path: Path, name: str) -> None:
    scenario = load_tuned(name, forms=FORMS)
    names, here = rows(scenario)
    back = through_ssp(scenario, tmp_path / "x.ssp")
    found, there = rows(back)
    assert found == names
    assert back.stations == scenario.stations
    assert back.expect == scenario.expect
    for one, other in zip(here, there, strict=True):
        assert np.array_equal(one, other)


def test_a_package_is_valid_whole_and_always_the_same_bytes(tmp_path: Path) -> None:
    scenario = load_tuned("two_users_box", forms=FORMS)
    file = exported(scenario, tmp_path / "a.ssp")
    assert file.read_bytes() == exported(scenario, tmp_path / "b.ssp").read_bytes()
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path / "a")
    assert read_valid(tmp_path / "a" / "SystemStructure.ssd")[1] == []
    extra = load(tmp_path / "a" / "extra" / "org.cohaptic" / "scenario.yaml", forms=FORMS)
    assert extra.ticks == scenario.ticks
    assert rows_equal(extra, scenario)


def rows_equal(one: Scenario, other: Scenario) -> bool:
    first, second = rows(one), rows(other)
    return first[0] == second[0] and all(
        np.array_equal(a, b) for a, b in zip(first[1], second[1], strict=True)
    )


def test_a_table_goes_along(tmp_path: Path) -> None:
    (tmp_path / "table.txt").write_text("0 1\n1 2\n")
    (tmp_path / "s.yaml").write_text(
        "cohaptic: 1\nduration: 0.5\ncomponents:\n  s: {fmu: signal, rate: 100, "
        "parameters: {mode: table, table_file: table.txt}}\n"
    )
    scenario = load(tmp_path / "s.yaml")
    names, here = rows(scenario)
    back = through_ssp(scenario, tmp_path / "s.ssp")
    (tmp_path / "table.txt").unlink()
    assert rows(back)[0] == names
    assert np.array_equal(rows(back)[1][0], here[0])


def test_texts_and_binaries_go_along(tmp_path: Path) -> None:
    """Values of one and of several elements, and what is wired."""
    two = '<Dimension start="2"/>'
    given = {"causality": "parameter", "variability": "fixed"}
    variables = "".join(
        scalar(3, name, reference, kind, inside + start, **more)
        for name, reference, kind, inside, start, more in (
            ("word", 1, "String", "", '<Start value="x"/>', given),
            ("words", 2, "String", two, '<Start value="x"/><Start value="y"/>', given),
            ("datas", 4, "Binary", two, '<Start value="00"/><Start value="01"/>', given),
            ("one", 6, "Float64", '<Dimension start="1"/>', "", given | {"start": "1"}),
            ("b_in", 8, "Binary", "", '<Start value="ff"/>', {"causality": "input"}),
            ("b_out", 8, "Binary", "", "", {"causality": "output"}),
        )
    )
    fmu = foreign_fmu(
        tmp_path, 3, variables, structure='<Output valueReference="8" dependencies=""/>'
    )
    parameters = {
        "word": "a b", "words": ["c", "d"], "datas": ["hex:0a", "hex:0b0c"], "one": [2.0],
    }  # fmt: skip
    part = {"fmu": str(fmu), "rate": 10, "parameters": parameters}
    written = {"duration": 1, "components": {"p": part, "q": part}}
    scenario = scenario_of(tmp_path, written | {"connections": ["p.b_out -> q.b_in"]})
    back = through_ssp(scenario, tmp_path / "x.ssp")
    assert [str(each) for each in back.connections] == ["p.b_out -> q.b_in"]
    with assemble(scenario) as here, assemble(back) as there:
        for name in "pq":
            one, other = (each.assembly.participants[name].parameters for each in (here, there))
            assert one == other == {
                "word": ["a b"], "words": ["c", "d"], "datas": [b"\n", b"\x0b\x0c"], "one": [2.0],
            }  # fmt: skip


def test_what_is_turned_sampled_and_expected_goes_along(tmp_path: Path) -> None:
    """And times, transformations, sizes, names with blanks, and that nothing is recorded."""
    size = {"causality": "structuralParameter", "variability": "fixed", "start": "2"}
    tuned = {"causality": "parameter", "variability": "tunable", "start": "1", "unit": "m"}
    variables = (
        scalar(3, "y", 1, causality="output", initial="exact", start="0", unit="m")
        + scalar(3, "u (1)", 2, causality="input", start="0", unit="m")
        + scalar(3, "p", 3, **tuned)
        + scalar(3, "n", 4, "UInt64", **size)
        + scalar(3, "a", 5, inside='<Dimension valueReference="4"/>', causality="local")
    )
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
            if (is(call, "DoStep"))
                m->real[1] = m->real[1] / 2 + m->real[2] + m->real[3];
            return 0;
        }
        #define HOOK hook
    """
    units = (
        '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit><Unit name="mm">'
        '<BaseUnit m="1" factor="0.001"/></Unit></UnitDefinitions>'
    )
    structure = '<Output valueReference="1" dependencies=""/>'
    fmu = foreign_fmu(tmp_path, 3, variables, structure=structure, snippet=snippet, before=units)
    part = {"fmu": str(fmu), "rate": "1024/16", "parameters": {"n": 3, "p": "20 mm"}}
    written = {
        "title": "a <b> & \a c",
        "start_time": 1,
        "duration": "2/3",
        "base_rate": 192,
        "components": {
            "one": {**part, "station": "s"},
            "two": {**part, "station": "t", "isolate": "process"},
        },
        "channels": {
            "lan": {"between": ["s", "t"], "rate": 64, "round_trip_delay": 4, "loss": "10 %"}
        },
        "connections": [
            {"from": "one.y", "to": "two.u (1)", "via": "lan", "factor": 0.1, "offset": -3}
        ],
        "knobs": {"one.p": {"minimum": 0}, "lan.forward.loss": {"maximum": "50 %"}},
        "events": [{"at": 1.25, "set": {"one.p": "30 mm", "lan.forward.loss": "40 %"}}],
        "expect": {"one.y": {"max_abs_below": 7}},
    }
    scenario = scenario_of(tmp_path, written)
    back = through_ssp(scenario, tmp_path / "x.ssp")
    for each in ("title", "start_time", "duration", "events", "knobs", "expect"):
        assert getattr(back, each) == getattr(scenario, each), each
    (names, here), (others, there) = rows(scenario), rows(back)
    assert names == others
    assert all(np.array_equal(one, other) for one, other in zip(here, there, strict=True))
    nothing = through_ssp(scenario_of(tmp_path, written | {"record": []}), tmp_path / "y.ssp")
    assert nothing.record == ()


def test_a_text_that_xml_cannot_carry_is_refused(tmp_path: Path) -> None:
    word = {"causality": "parameter", "variability": "fixed"}
    fmu = foreign_fmu(tmp_path, 3, scalar(3, "s", 1, "String", '<Start value="x"/>', **word))
    part = {"fmu": str(fmu), "rate": 10, "parameters": {"s": "a\tb"}}
    through_ssp(
        scenario_of(tmp_path, {"duration": 1, "components": {"p": part}}), tmp_path / "x.ssp"
    )
    part["parameters"] = {"s": "a\ab"}
    scenario = scenario_of(tmp_path, {"duration": 1, "components": {"p": part}})
    with pytest.raises(InputError, match=r"p\.s cannot be exported: it has characters that XML"):
        exported(scenario, tmp_path / "y.ssp")


@pytest.mark.parametrize(
    ("part", "said"),
    [
        (
            "python: 'mine:Mine'",
            r"it cannot be exported: its class \(.*mine.py:Mine\) lies in no",
        ),
        ("python: 'mine.py:Mine'", "it cannot be exported: its class"),
        ("device: 'mock://'", "it cannot be exported: an SSP holds FMUs, and names classes"),
    ],
)
def test_what_lies_elsewhere_cannot_be_exported(tmp_path: Path, part: str, said: str) -> None:
    (tmp_path / "mine.py").write_text(
        "from tests.support.master.master_parts import Growing\nclass Mine(Growing): pass\n"
    )
    (tmp_path / "s.yaml").write_text(
        f"cohaptic: 1\nduration: 0.5\ncomponents:\n  it: {{{part}, rate: 100}}\n"
    )
    with pytest.raises(InputError, match=said):
        exported(load(tmp_path / "s.yaml"), tmp_path / "s.ssp")


def test_the_commands(tmp_path: Path) -> None:
    def cohaptic(*arguments: str) -> str:
        done = CliRunner().invoke(cli, list(arguments))
        assert done.exit_code == 0, (done.output, done.exception)
        return done.stdout

    package, scenario = tmp_path / "box.ssp", tmp_path / "box.yaml"
    cohaptic("ssp", "export", "single_user", "--set", "duration=0.25", "--out", str(package))
    ran = cohaptic("run", str(package), "--out", str(tmp_path / "a"), "--no-figure", "--json")
    assert json.loads(ran)["ticks"] == 256
    cohaptic("ssp", "import", str(package), "--out", str(scenario))
    cohaptic("run", str(scenario), "--out", str(tmp_path / "b"), "--no-figure")
    digests = [cohaptic("record", "digest", str(tmp_path / name)).split()[0] for name in "ab"]
    assert digests[0] == digests[1]
    again = CliRunner().invoke(cli, ["ssp", "import", str(package), "--out", str(scenario)])
    assert isinstance(again.exception, InputError)


@pytest.mark.parametrize("mode", [", event_mode: true", ", event_mode: false", ""])
def test_clocks_tick_as_before_on_the_way_back(tmp_path: Path, mode: str) -> None:
    path = clocked_fmu(tmp_path)
    connections = ["a.n -> b.d"]
    if "false" not in mode:
        connections += ["a.told -> b.triggered", "a.told.age -> c.d", "a.y -> b.uc"]
    scenario = scenario_of(
        tmp_path,
        "duration: 0.3\nbase_rate: 100\ncomponents:\n"
        + "".join(f"  {name}: {{fmu: {path}, rate: 100{mode}}}\n" for name in "abc")
        + f"connections: [{', '.join(connections)}]\n",
    )
    file = tmp_path / "clocks.ssp"
    back = through_ssp(scenario, file)
    names, expected = rows(scenario)
    assert ("a.told.age" in names) == ("false" not in mode)
    found_names, found = rows(back)
    assert found_names == names
    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
    with zipfile.ZipFile(file) as archive:
        structure = archive.read("SystemStructure.ssd").decode()
    shown = re.findall(r'Connector name="([^"]*)" kind="\w+">\s*<ssc:Clock', structure)
    assert shown == ([] if "false" in mode else ["triggered", "told"] * 3)
    assert 'Connector name="told.age"' not in structure
