"""Archives, descriptions and ranges that are unusual: they run, or what is wrong is said truly."""

from __future__ import annotations

import stat
import zipfile
from pathlib import Path

import pytest

from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

STRUCTURE = '<Output valueReference="1" dependencies=""/>'
Y = scalar(3, "y", 1, causality="output", start="3", initial="exact")


def component(path: Path, more: str = "") -> str:
    return f"duration: 1\ncomponents:\n  it: {{fmu: {path}, rate: 10{more}}}\n"


def repacked(path: Path, rename, folder: Path) -> Path:
    """Another archive of the same files; ``rename`` gives an entry's name, or ``None``."""
    new = folder / f"re{path.name}"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(new, "w") as archive:
        for entry in old.infolist():
            if (name := rename(entry.filename)) is not None:
                found = zipfile.ZipInfo(name)
                found.filename = name
                archive.writestr(found, old.read(entry))
    return new


def library(name: str) -> bool:
    return name.startswith("binaries/")


def test_backslashes_of_windows_tools_are_folders(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE)
    odd = repacked(path, lambda name: name.replace("/", "\\"), tmp_path)
    with zipfile.ZipFile(odd) as archive:
        assert any("\\" in name for name in archive.namelist())
    sink, _ = run(scenario_of(tmp_path, component(odd)))
    assert len(sink.signal("it.y")) == 10


@pytest.mark.parametrize(
    ("rename", "said"),
    [
        (
            lambda name: name.replace("foreign.so", "foreign.so/x") if library(name) else name,
            "foreign.so of the FMU .* is a folder, not a library",
        ),
        (
            lambda name: name.replace("foreign.so", "other.so") if library(name) else name,
            r"has to be called foreign\.so, .* there is other\.so",
        ),
        (
            lambda name: name.replace("foreign.so", "foreign.txt") if library(name) else name,
            "there is no library at all",
        ),
        (lambda name: f"folder/{name}", "no modelDescription.xml at its top"),
        (
            lambda name: name + "/x" if name == "modelDescription.xml" else name,
            "modelDescription.xml .* is a folder",
        ),
    ],
)
def test_what_lies_in_a_wrong_place_is_said(tmp_path: Path, rename, said: str) -> None:
    path = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE)
    with pytest.raises(InputError, match=said):
        assemble(scenario_of(tmp_path, component(repacked(path, rename, tmp_path))))


def test_a_link_is_refused_by_its_name(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE)
    with zipfile.ZipFile(path, "a") as archive:
        link = zipfile.ZipInfo("resources/outside")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(InputError, match="has a link 'resources/outside'"):
        assemble(scenario_of(tmp_path, component(path)))


def test_what_an_fmu_writes_into_its_own_folder_does_not_reach_the_next_run(
    tmp_path: Path,
) -> None:
    path = foreign_fmu(
        tmp_path, 3, Y, structure=STRUCTURE, extra={"resources/table.txt": "as it was"}
    )
    with assemble(scenario_of(tmp_path, component(path))) as simulation:
        fmu = simulation.assembly.participants["it"].fmu
        assert fmu is not None
        (fmu.folder / "resources" / "table.txt").write_text("as the first run left it")
        (fmu.folder / "resources" / "new.txt").write_text("and more")
    with assemble(scenario_of(tmp_path, component(path))) as simulation:
        assert (fmu.folder / "resources" / "table.txt").read_text() == "as it was"
        assert not (fmu.folder / "resources" / "new.txt").exists()
        simulation.run()


def test_scheduled_execution_is_called_by_its_name(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE)
    text = zipfile.ZipFile(path).read("modelDescription.xml").decode()
    changed = tmp_path / "scheduled.fmu"
    with zipfile.ZipFile(changed, "w") as archive:
        archive.writestr(
            "modelDescription.xml", text.replace("<CoSimulation", "<ScheduledExecution")
        )
    with pytest.raises(InputError, match="it is for scheduled execution"):
        assemble(scenario_of(tmp_path, component(changed)))


def test_clocked_outputs_are_skipped_by_name(tmp_path: Path) -> None:
    variables = (
        Y
        + scalar(3, "ticking", 2, "Clock", causality="output", intervalVariability="triggered")
        + scalar(3, "held", 4, causality="output", variability="discrete", clocks="2")
    )
    structure = STRUCTURE + '<Output valueReference="2"/><Output valueReference="4"/>'
    snippet = """
        static int hook(Foreign *m, const char *call) { return 0; }
        #define HOOK hook
    """
    path = foreign_fmu(tmp_path, 3, variables, structure=structure, snippet=snippet)
    scenario = scenario_of(tmp_path, component(path, ", feedthrough: true"))
    sink = MemorySink()
    with assemble(scenario) as simulation:
        (note,) = simulation.notes
        assert "it: ticking, held of the FMU foreign.fmu belong to clocks" in note
        simulation.run(sink)
    names = [column.name for group in sink.groups for column in group.columns]
    assert names == ["it.y"]
    with pytest.raises(InputError, match=r"it\.held belongs to a clock"):
        assemble(scenario_of(tmp_path, component(path) + "record: [it.held]\n"))


@pytest.mark.parametrize("version", [2, 3])
def test_a_calculated_start_is_read_past_and_not_set(tmp_path: Path, version: int) -> None:
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
            if (is(call, "ExitInitializationMode"))
                m->real[1] = 7;
            return is(call, "SetReal") || is(call, "SetFloat64") ? 3 : 0;
        }
        #define HOOK hook
    """
    structure = STRUCTURE
    if version == 2:
        structure = '<Outputs><Unknown index="1" dependencies=""/></Outputs>'
    variables = scalar(version, "y", 1, causality="output", initial="calculated", start="3")
    path = foreign_fmu(tmp_path, version, variables, structure=structure, snippet=snippet)
    sink, simulation = run(scenario_of(tmp_path, component(path)))
    assert sink.signal("it.y")[0] == 7.0
    assert "is not valid" in simulation.notes[0]


LEVELS = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep"))
            m->whole[1]++;
        return 0;
    }
    #define HOOK hook
"""


@pytest.mark.parametrize("version", [2, 3])
def test_a_value_outside_of_an_enumeration_is_refused_where_it_arrives(
    tmp_path: Path, version: int
) -> None:
    def types(count: int) -> str:
        items = "".join(f'<Item name="level_{n}" value="{n}"/>' for n in range(1, count + 1))
        if version == 3:
            inner = f'<EnumerationType name="Levels">{items}</EnumerationType>'
        else:
            inner = f'<SimpleType name="Levels"><Enumeration>{items}</Enumeration></SimpleType>'
        return f"<TypeDefinitions>{inner}</TypeDefinitions>"

    kind = {"declaredType": "Levels", "start": "1"}
    structure = STRUCTURE
    if version == 2:
        structure = '<Outputs><Unknown index="1" dependencies=""/></Outputs>'
    source = foreign_fmu(
        tmp_path, version,
        scalar(version, "y", 1, "Enumeration", causality="output", initial="exact", **kind),
        before=types(9), snippet=LEVELS, structure=structure, name="source",
    )  # fmt: skip
    target = foreign_fmu(
        tmp_path,
        version,
        scalar(version, "u", 1, "Enumeration", causality="input", **kind),
        before=types(3),
        name="target",
    )
    text = (
        f"duration: 1\ncomponents:\n  a: {{fmu: {source}, rate: 10, start: {{y: 1}}}}\n"
        f"  b: {{fmu: {target}, rate: 10}}\nconnections: [a.y -> b.u]\n"
    )
    with (
        assemble(scenario_of(tmp_path, text)) as simulation,
        pytest.raises(RunError, match=r"b\.u cannot take 4 at tick .*level_1 \(1\), level_2"),
    ):
        simulation.run()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("status", "said"), [(2, "a higher rate makes shorter ones"), (5, "it steps asynchronously")]
)
def test_what_to_do_about_a_step_is_said(
    tmp_path: Path, version: int, status: int, said: str
) -> None:
    snippet = f"""
        static int hook(Foreign *m, const char *call)
        {{
            return is(call, "DoStep") ? {status} : 0;
        }}
        #define HOOK hook
    """
    u = scalar(version, "u", 1, causality="input", start="0")
    path = foreign_fmu(tmp_path, version, u, snippet=snippet)
    with pytest.raises(RunError, match=said):
        run(scenario_of(tmp_path, component(path)))
