"""Whatever an FMU does to its process, the command has status 1, a sentence and the record."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cosim.record.reader import open_run
from tests.support.fmus.foreign import foreign_fmu, scalar

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a child needs Linux")

TICKS = 8
WAYS = {
    "exit(0)": ("exit(0)", "ended the process (exit status 0)"),
    "_exit(0)": ("_exit(0)", "ended the process (exit status 0)"),
    "exit(3)": ("exit(3)", "ended the process (exit status 3)"),
    "abort": ("abort()", "crashed (SIGABRT: aborted)"),
    "SIGSEGV": ("*(volatile int *)8 = 1", "crashed (SIGSEGV: segmentation fault)"),
    "SIGFPE": ("raise(8)", "crashed (SIGFPE: floating point exception)"),
}
EARLY = "before the first tick; nothing was recorded"
WHOLE = f"at tick {TICKS} ({TICKS} s); the record is complete"
CALLS = {
    "Instantiate": (EARLY, "in {name} "),
    "SetString": (EARLY, "in {name} "),
    "EnterInitializationMode": (EARLY, "in {name} "),
    "ExitInitializationMode": (EARLY, "in {name} "),
    "initial Get": ("while its outputs were read at initialisation; nothing was recorded", ""),
    "DoStep": ("in its step at tick 3 (3 s); what was written before is kept", ""),
    "Set": ("while its inputs were set at tick 3 (3 s); what was written before is kept", ""),
    "Get": ("while its outputs were read at tick 3 (3 s); what was written before is kept", ""),
    "Terminate": (WHOLE, "in {name} "),
    "FreeInstance": (WHOLE, "in {name} "),
}


def dying(folder: Path, version: int, call: str, code: str) -> Path:
    kind = {2: "Real", 3: "Float64"}[version]
    name = {"Set": f"Set{kind}", "Get": f"Get{kind}", "initial Get": f"Get{kind}"}.get(call, call)
    late = {"DoStep": "m->time >= 3", "Set": "m->time >= 2", "Get": "m->time >= 2"}
    snippet = f"""
        void exit(int); void _exit(int); void abort(void); int raise(int);
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "{name}") && {late.get(call, "1")})
                {code};
            return 0;
        }}
        #define HOOK hook
    """
    variables = (
        scalar(version, "u", 1, causality="input", start="0")
        + scalar(version, "y", 2, causality="output")
        + scalar(
            version, "p", 3, "String", '<Start value="x"/>' if version == 3 else "",
            causality="parameter", variability="fixed", **({"start": "x"} if version == 2 else {}),
        )
    )  # fmt: skip
    structure = '<Output valueReference="2" dependencies=""/>'
    if version == 2:
        structure = '<Outputs><Unknown index="2" dependencies=""/></Outputs>'
    return foreign_fmu(folder, version, variables, snippet=snippet, structure=structure)


def command(folder: Path, fmu: Path, *options: str) -> list[str]:
    more = ", feedthrough: true, parameters: {p: text}"
    (folder / "test.yaml").write_text(
        f"cohaptic: 1\nduration: {TICKS}\nbase_rate: 1\ncomponents:\n"
        "  hand: {fmu: hand, rate: 1}\n"
        f"  box: {{fmu: {fmu}, rate: 1{more}}}\n"
        "connections: [hand.position -> box.u]\n"
    )
    run = "from cosim.cli import main; main()"
    arguments = ("run", "test.yaml", "--out", "out", "--no-figure", *options)
    return [sys.executable, "-c", run, *arguments]


def ended(folder: Path, fmu: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(folder, fmu), cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("call", CALLS)
def test_exit_0_in_any_call_is_a_failure_with_its_place(
    tmp_path: Path, call: str, version: int
) -> None:
    place, of_the_standard = CALLS[call]
    done = ended(tmp_path, dying(tmp_path, version, call, "exit(0)"))
    full = {
        ("Instantiate", 3): "InstantiateCoSimulation",
    }.get((call, version), call)
    name = of_the_standard.format(name=f"fmi{version}{full}")
    assert done.returncode == 1, done.stderr
    assert f"box ended the process (exit status 0) {name}{place}." in done.stderr
    assert "Traceback" not in done.stderr
    _record_is_right(tmp_path, place, done.stderr)


@pytest.mark.parametrize("way", WAYS)
def test_every_way_of_dying_has_its_sentence(tmp_path: Path, way: str) -> None:
    code, said = WAYS[way]
    done = ended(tmp_path, dying(tmp_path, 3, "DoStep", code))
    assert done.returncode == 1
    assert f"box {said} in its step at tick 3 (3 s); what was written" in done.stderr
    _record_is_right(tmp_path, "kept", done.stderr)


def _record_is_right(folder: Path, place: str, said: str) -> None:
    out = folder / "out"
    if "nothing was recorded" in place:
        assert not out.exists()
        return
    summary = json.loads((out / "summary.json").read_text())
    manifest = json.loads((out / "manifest.json").read_text())
    assert summary["status"] == manifest["exit"]["status"] == 1
    assert summary["message"] == manifest["exit"]["message"]
    assert summary["message"] in said
    with open_run(out) as run:
        assert run.ticks == TICKS if "complete" in place else run.ticks <= 4
        assert all(group.capacity == group.rows for group in run.groups.values())


@pytest.mark.parametrize("call", ["sys.exit(0)", "os._exit(0)"])
def test_a_python_component_cannot_leave_with_success_either(tmp_path: Path, call: str) -> None:
    (tmp_path / "mine.py").write_text(
        "import os, sys\nfrom cosim.base.component import *\n\nclass Leaves(Component):\n"
        "    variables = (Variable(name='y', causality=Causality.OUTPUT),)\n"
        "    def initialise(self, setup, inputs, outputs): pass\n"
        f"    def step(self, tick):\n        if tick == 3: {call}\n"
    )
    run = command(tmp_path, Path("none"))
    (tmp_path / "test.yaml").write_text(
        "cohaptic: 1\nduration: 8\nbase_rate: 1\n"
        "components: {it: {python: 'mine:Leaves', rate: 1}}\n"
    )
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "it " in done.stderr
    assert "in a method of its class at tick 3 (3 s)" in done.stderr


SLOW = """
    int usleep(unsigned);
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep"))
            usleep(50000);
        return 0;
    }
    #define HOOK hook
"""


@pytest.mark.parametrize("everybody", [False, True])
def test_ctrl_c_ends_the_run_between_two_ticks(tmp_path: Path, everybody: bool) -> None:
    """Sent to the parent alone, or to the whole group as a terminal does."""
    fmu = foreign_fmu(tmp_path, 3, scalar(3, "u", 1, causality="input", start="0"), snippet=SLOW)
    run = command(tmp_path, fmu)
    (tmp_path / "test.yaml").write_text(
        f"cohaptic: 1\nduration: 1000\nbase_rate: 1\ncomponents:\n  box: {{fmu: {fmu}, rate: 1}}\n"
        "record: [box.u]\n"
    )
    process = subprocess.Popen(
        run, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    deadline = time.monotonic() + 20
    while not (tmp_path / "out" / "run.h5").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    (os.killpg if everybody else os.kill)(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 1
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert 0 < summary["ticks"] < 1000
    assert f"Interrupted at tick {summary['ticks']} of 1000" in said


def test_the_child_dies_with_its_parent(tmp_path: Path) -> None:
    fmu = foreign_fmu(tmp_path, 3, scalar(3, "u", 1, causality="input", start="0"), snippet=SLOW)
    run = command(tmp_path, fmu)
    (tmp_path / "test.yaml").write_text(
        f"cohaptic: 1\nduration: 1000\nbase_rate: 1\ncomponents:\n  box: {{fmu: {fmu}, rate: 1}}\n"
    )
    process = subprocess.Popen(run, cwd=tmp_path, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 20
    while not (tmp_path / "out" / "manifest.json").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    child = json.loads((tmp_path / "out" / "manifest.json").read_text())["process"]
    assert child != process.pid
    process.kill()
    process.wait()
    deadline = time.monotonic() + 10
    while is_alive(child) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_alive(child)


def is_alive(process: int) -> bool:
    """Whether it still runs; one that nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except OSError:
        return False
