"""What an FMU does to its process, as a user sees it: the command's status, words and files."""

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
from tests.support.fmus.dying import command, dying, ended, record_is_right, sentence
from tests.support.fmus.foreign import foreign_fmu, scalar

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a child needs Linux")
PACED = 100
"""Ticks a second of the paced runs: nothing here hangs on their being met."""


@pytest.mark.parametrize(("version", "call"), [(2, "DoStep"), (3, "Terminate")])
def test_exit_0_is_a_failure_with_its_place(tmp_path: Path, call: str, version: int) -> None:
    where, place = sentence(call, version)
    done = ended(tmp_path, dying(tmp_path, version, call, "exit(0)"))
    assert done.returncode == 1, done.stderr
    assert f"box ended the process (exit status 0) {where}." in done.stderr
    assert "Traceback" not in done.stderr
    record_is_right(tmp_path, place, done.stderr)


@pytest.mark.parametrize("option", ["--snapshot=0.02 s", "--realtime"])
def test_the_record_is_finished_before_fmus_are_freed_however_it_runs(
    tmp_path: Path, option: str
) -> None:
    where, place = sentence("Terminate", 3, PACED)
    fmu = dying(tmp_path, 3, "Terminate", "exit(0)", PACED)
    done = ended(tmp_path, fmu, option, rate=PACED)
    assert done.returncode == 1, done.stderr
    assert f"box ended the process (exit status 0) {where}" in done.stderr
    record_is_right(tmp_path, place, done.stderr)


SAYS = 'say(m, 3, "the licence has expired"), '


@pytest.mark.parametrize("call", ["Instantiate", "DoStep"])
@pytest.mark.parametrize("keys", ["", ", isolate: process"])
@pytest.mark.parametrize("options", [(), ("--realtime",)])
def test_what_it_had_said_is_in_the_sentence_and_in_the_log(
    tmp_path: Path, call: str, keys: str, options: tuple[str, ...]
) -> None:
    rate = PACED if options else 1
    fmu = dying(tmp_path, 3, call, SAYS + "abort()", rate)
    done = ended(tmp_path, fmu, *options, rate=rate, keys=keys)
    assert done.returncode == 1
    said = f"box crashed (SIGABRT: aborted) {sentence(call, 3, rate)[0].partition(';')[0]}"
    assert f"{said}; it said: the licence has expired" in done.stderr
    log = tmp_path / "out" / "fmu.log"
    if call == "DoStep":
        assert log.read_text() == "box: error: the licence has expired\n"


def test_the_record_has_what_was_flushed(tmp_path: Path) -> None:
    """Twice a second; the FMU dies after one second and a bit, in steps of 10 ms."""
    rate, dies = 100, 130
    variables = scalar(3, "y", 1, causality="output")
    snippet = f"""
        void _exit(int); int usleep(unsigned);
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "DoStep")) {{
                usleep(10000);
                m->real[1] = m->last;
                if (m->time > {(dies - 0.5) / rate})
                    _exit(0);
            }}
            return 0;
        }}
        #define HOOK hook
    """
    output = '<Output valueReference="1" dependencies=""/>'
    fmu = foreign_fmu(tmp_path, 3, variables, snippet=snippet, structure=output)
    run = command(tmp_path, fmu)
    (tmp_path / "test.yaml").write_text(
        f"cohaptic: 1\nduration: 9\nbase_rate: {rate}\n"
        f"components: {{box: {{fmu: {fmu}, rate: {rate}}}}}\nrecord: [box.y]\n"
    )
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert f"box ended the process (exit status 0) in its step at tick {dies} (1.3 s); " in (
        done.stderr
    )
    with open_run(tmp_path / "out") as kept:
        rows = kept["box.y"].values
        assert 1 < len(rows) <= dies + 1
        assert rows.tolist() == pytest.approx([tick / rate for tick in range(len(rows))])


@pytest.mark.parametrize("options", [(), ("--realtime",)])
@pytest.mark.parametrize("call", ["sys.exit(0)", "os._exit(0)"])
@pytest.mark.parametrize(
    ("method", "where"),
    [
        ("initialise", "in its initialisation before the first tick; nothing was recorded"),
        ("step", "in a method of its class at tick 3 (3 s); what was written before is kept"),
        ("close", "in its closing at tick 8 (8 s); what was written before is kept"),
    ],
)
def test_a_python_component_cannot_leave_with_success_either(
    tmp_path: Path, method: str, where: str, call: str, options: tuple[str, ...]
) -> None:
    body = {"initialise": "pass", "step": "pass", "close": "pass"}
    body[method] = f"tick in (None, 3) and {call}"
    (tmp_path / "mine.py").write_text(
        "import os, sys\nfrom cosim.base.component import *\n\nclass Leaves(Component):\n"
        "    variables = (Variable(name='y', causality=Causality.OUTPUT),)\n"
        f"    def initialise(self, setup, inputs, outputs, tick=None): {body['initialise']}\n"
        f"    def step(self, tick): {body['step']}\n"
        f"    def close(self, tick=None): {body['close']}\n"
    )
    run = command(tmp_path, Path("none"), *options)
    (tmp_path / "test.yaml").write_text(
        f"cohaptic: 1\nduration: {0.08 if options else 8}\nbase_rate: {100 if options else 1}\n"
        f"components: {{it: {{python: 'mine:Leaves', rate: {100 if options else 1}}}}}\n"
    )
    for tick in (3, 8) if options else ():
        where = where.replace(f"({tick} s)", f"({tick / 100:g} s)")
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "it " in done.stderr
    assert where in done.stderr


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


STUCK = '{ int open(const char *, int, ...); open("stuck", 65, 0600); for (;;) pause(); }'


def wait_for(file: Path) -> None:
    deadline = time.monotonic() + 30
    while not file.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert file.exists()


def ends_by_ctrl_c(folder: Path, call: str, *options: str, keys: str = "", times: int) -> str:
    """What the command says that is interrupted so often, of an FMU that does not come back."""
    fmu = dying(folder, 3, call, STUCK, PACED)
    process = subprocess.Popen(
        command(folder, fmu, *options, rate=PACED, keys=keys),
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(folder / "stuck")
    for _ in range(times):
        process.send_signal(signal.SIGINT)
        time.sleep(1.3)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 1
    return said


@pytest.mark.slow
@pytest.mark.parametrize("keys", ["", ", isolate: process"])
@pytest.mark.parametrize("call", ["Instantiate", "DoStep"])
def test_a_call_without_an_end_is_left_at_the_second_ctrl_c(
    tmp_path: Path, call: str, keys: str
) -> None:
    where, place = sentence(call, 3, PACED)
    said = ends_by_ctrl_c(tmp_path, call, keys=keys, times=2)
    where, _, kept = where.partition("; ")
    ended = f"box did not come back {where}, so that Ctrl-C ended it; {kept}."
    if keys and call == "Instantiate":  # Python waits for the other process, and hears the first
        ended = "Interrupted before the first tick; nothing was recorded."
    assert ended in said
    record_is_right(tmp_path, place, said)


@pytest.mark.slow
def test_a_paced_call_without_an_end_is_left_at_the_first_ctrl_c(tmp_path: Path) -> None:
    said = ends_by_ctrl_c(tmp_path, "DoStep", "--realtime", times=1)
    assert (
        "the control loop did not end; it was killed while box was at work in its step at tick 3 "
        "(0.03 s)" in said
    )


@pytest.mark.slow
def test_whoever_is_slow_is_not_given_up(tmp_path: Path) -> None:
    """Steps of 50 ms: an interrupt ends it between two of them."""
    fmu = foreign_fmu(tmp_path, 3, scalar(3, "u", 1, causality="input", start="0"), snippet=SLOW)
    run = command(tmp_path, fmu)
    (tmp_path / "test.yaml").write_text(
        f"cohaptic: 1\nduration: 1000\nbase_rate: 1\ncomponents:\n  box: {{fmu: {fmu}, rate: 1}}\n"
    )
    process = subprocess.Popen(run, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    wait_for(tmp_path / "out" / "run.h5")
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert "Interrupted at tick" in said


def is_alive(process: int) -> bool:
    """Whether it still runs; one that nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except OSError:
        return False
