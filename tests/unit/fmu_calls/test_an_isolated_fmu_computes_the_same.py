"""In a process of its own an FMU gives the same bits, says the same, and dies alone."""

from __future__ import annotations

import os
import signal
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import fmus.probe
from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.fmu.binding import platform_folder
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import load
from fmus.compiler import compile_library, host_platform
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="it needs POSIX")
ROOT = Path(__file__).parents[3]
OUTPUT = '<Output valueReference="1" dependencies=""/>'
OUTPUTS = {2: '<Outputs><Unknown index="1" dependencies=""/></Outputs>', 3: OUTPUT}


def rows(sink: MemorySink) -> list[np.ndarray]:
    return [sink.rows(number) for number in range(len(sink.groups))]


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_a_whole_scenario_apart_has_the_same_bits(flavour: str) -> None:
    """Ten FMUs of two users and a box, a quarter of a second of it: every signal."""
    found = []
    for isolated in (False, True):
        sets = ["duration=0.25"]
        for name, part in load(ROOT / "scenarios" / "two_users_box.yaml").components.items():
            if part.kind == "fmu":
                sets += [f"components.{name}.flavour={flavour}"]
                sets += [f"components.{name}.isolate=process"] * isolated
        sink, simulation = run(load(ROOT / "scenarios" / "two_users_box.yaml", sets=sets))
        assert all(each.is_isolated is isolated for each in simulation.fmus.values())
        found.append(rows(sink))
    for here, apart in zip(*found, strict=True):
        assert np.array_equal(here, apart)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_every_type_crosses(tmp_path: Path, flavour: str) -> None:
    probe = fmus.probe.find("probe_types", flavour)
    found = []
    for more in ({}, {"isolate": "process"}):
        part = {"fmu": str(probe), "rate": 100, **more}
        sink, _ = run(scenario_of(tmp_path, {"duration": 0.1, "components": {"it": part}}))
        found.append(rows(sink))
    for here, apart in zip(*found, strict=True):
        assert np.array_equal(here, apart)


def test_a_snapshot_is_taken_and_put_back_over_there(tmp_path: Path) -> None:
    part = {"fmu": "pantograph", "rate": 1024, "isolate": "process"}
    scenario = scenario_of(tmp_path, {"duration": 1, "components": {"it": part}})
    with assemble(scenario) as simulation:
        simulation.start()
        simulation.advance(100)
        snapshot = simulation.snapshot()
        simulation.advance(200)
        cells = simulation.program.cells.copy()
        simulation.restore(snapshot)
        simulation.advance(200)
        assert np.array_equal(cells, simulation.program.cells)


SAYING = """
    void abort(void);
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep") && m->time > 0.025) {
            say(m, 3, "the valve is stuck");
            return 3;
        }
        return 0;
    }
    #define HOOK hook
"""


def test_its_own_reason_reaches_the_sentence_and_the_log(tmp_path: Path) -> None:
    path = foreign_fmu(
        tmp_path, 3, scalar(3, "y", 1, causality="output"), structure=OUTPUT, snippet=SAYING
    )
    part = {"fmu": str(path), "rate": 100, "isolate": "process"}
    with assemble(scenario_of(tmp_path, {"duration": 1, "components": {"it": part}})) as simulation:
        with pytest.raises(RunError, match=r"it returned status 'error' .* the valve is stuck"):
            simulation.run()
        assert [str(each) for each in simulation.outcome.said["it"]] == [
            "error: the valve is stuck"
        ]


def killed(simulation: Simulation, name: str) -> int:
    process = simulation.fmus[name]._residence.process
    assert process is not None
    os.kill(process._process.pid, signal.SIGKILL)
    return process._process.pid


def test_a_death_between_two_ticks_costs_a_sentence_and_the_rest_is_closed(tmp_path: Path) -> None:
    parts = {name: {"fmu": "pantograph", "rate": 1024, "isolate": "process"} for name in "ab"}
    with assemble(scenario_of(tmp_path, {"duration": 1, "components": parts})) as simulation:
        simulation.start()
        simulation.advance(100)
        killed(simulation, "a")
        with pytest.raises(RunError, match=r"a crashed \(SIGKILL: killed\) .* at tick 100"):
            simulation.advance(200)
        other = simulation.fmus["b"]._residence.process
        assert other is not None
    assert other._process.returncode == 0
    assert simulation.closing_error == ""


def test_a_refusal_over_there_is_a_refusal_here(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, scalar(3, "y", 1, causality="output"), structure=OUTPUT)
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(broken, "w") as new:
        for name in old.namelist():
            new.writestr(name, b"no library" if name.endswith(".so") else old.read(name))
    part = {"fmu": str(broken), "rate": 100, "isolate": "process"}
    with (
        assemble(scenario_of(tmp_path, {"duration": 1, "components": {"it": part}})) as simulation,
        pytest.raises(InputError, match=r"it: broken\.fmu: the library foreign\.so cannot be"),
    ):
        simulation.run()


COUNTING = """
    static int made;
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "Instantiate") && made++)
            return 3;
        return 0;
    }
    #define HOOK hook
"""


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_that_exists_once_in_a_process_has_processes(tmp_path: Path, version: int) -> None:
    once = {"canBeInstantiatedOnlyOncePerProcess": "true"}
    path = foreign_fmu(
        tmp_path, version, scalar(version, "y", 1, causality="output"),
        structure=OUTPUTS[version], snippet=COUNTING, interface=once,
    )  # fmt: skip
    part = {"fmu": str(path), "rate": 100}
    parts = {"a": part, "b": part}
    with assemble(scenario_of(tmp_path, {"duration": 0.1, "components": parts})) as simulation:
        assert [note for note in simulation.notes if "only once in a process" in note] == [
            f"{name} has a process of its own: its FMU can be instantiated only once in a process"
            for name in "ab"
        ]
        assert simulation.run().ticks == 10
    with assemble(
        scenario_of(tmp_path, {"duration": 0.1, "components": {"a": part}})
    ) as simulation:
        assert simulation.notes == ()


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_that_needs_a_tool_is_apart(tmp_path: Path, version: int) -> None:
    path = foreign_fmu(
        tmp_path, version, scalar(version, "y", 1, causality="output"),
        structure=OUTPUTS[version], interface={"needsExecutionTool": "true"},
    )  # fmt: skip
    part = {"fmu": str(path), "rate": 100}
    with assemble(
        scenario_of(tmp_path, {"duration": 0.1, "components": {"a": part}})
    ) as simulation:
        assert "needsExecutionTool" in simulation.notes[0]
        assert simulation.run().ticks == 10


@pytest.mark.skipif(sys.platform != "linux", reason="it links with a run path of ELF")
def test_two_libraries_of_one_name_do_not_meet(tmp_path: Path) -> None:
    """Each FMU is linked against a ``libshared.so`` of its own, which lies beside it."""
    parts = {}
    for name, number in (("a", 1.0), ("b", 2.0)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "shared.c").write_text(
            f'__attribute__((visibility("default"))) double number(void) {{ return {number}; }}\n'
        )
        compile_library(host_platform(), folder / "libshared.so", [folder / "shared.c"])
        snippet = """
            typedef double (*Number)(void);
            void *dlopen(const char *, int); void *dlsym(void *, const char *);
            static int hook(Foreign *m, const char *call)
            {
                if (is(call, "ExitInitializationMode"))
                    m->real[1] = ((Number)dlsym(dlopen("libshared.so", 2), "number"))();
                return 0;
            }
            #define HOOK hook
        """
        beside = f"binaries/{platform_folder(3)}/libshared.so"
        path = foreign_fmu(
            folder, 3, scalar(3, "y", 1, causality="output"), structure=OUTPUT, name=name,
            snippet=LOADS_BESIDE + snippet.replace('dlopen("libshared.so", 2)', "beside()"),
        )  # fmt: skip
        with zipfile.ZipFile(path, "a") as archive:
            archive.write(folder / "libshared.so", beside)
        parts[name] = {"fmu": str(path), "rate": 100}
    sink = MemorySink()
    with assemble(scenario_of(tmp_path, {"duration": 0.1, "components": parts})) as simulation:
        assert all("library of the name libshared.so" in note for note in simulation.notes)
        simulation.run(sink)
    assert sink.signal("a.y")[-1] == 1.0
    assert sink.signal("b.y")[-1] == 2.0


LOADS_BESIDE = """
    struct info { const char *file; void *base; const char *name; void *at; };
    int dladdr(const void *, struct info *); void *dlopen(const char *, int);
    static char place[4096];
    /* By its SONAME's short name where one is loaded, as a run path does. */
    static void *beside(void)
    {
        struct info found;
        void *loaded = dlopen("libshared.so", 2 | 4);
        if (loaded)
            return loaded;
        dladdr(place, &found);
        int end = 0, slash = 0;
        for (; found.file[end]; end++) {
            place[end] = found.file[end];
            if (place[end] == '/')
                slash = end;
        }
        const char *name = "libshared.so";
        for (int i = 0; i < 13; i++)
            place[slash + 1 + i] = name[i];
        return dlopen(place, 2);
    }
"""
