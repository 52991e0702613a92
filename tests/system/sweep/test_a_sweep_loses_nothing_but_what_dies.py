"""Whatever ends a worker or the sweep itself: every other run is done once, and a resumed table is
the uninterrupted one."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.reading import FORMS
from cosim.sweep.job import Task
from cosim.sweep.planning.plan import Request, SweepPlan, plan_of
from cosim.sweep.results.store import RESULTS_FILE
from cosim.sweep.sweep import SweepOutcome, run_sweep
from cosim.sweep.work.runner import PointRunner
from tests.support.fmus.dying import command, dying, sentence
from tests.support.sweep.parts import SCENARIO

GAINS = 12


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "test.yaml"
    path.write_text(json.dumps(SCENARIO))
    return path


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    file = tmp_path / "counted"
    monkeypatch.setenv("COUNT_RUNS", str(file))
    return file


def plan(scenario: Path, ends: Any = (0,), gains: int = GAINS, **more: Any) -> SweepPlan:
    vary = {"part.gain": f"1..{gains}", "part.ends": list(ends)}
    measure = {"hand.position": ["max", "rms"], "part.value": "max"}
    given: dict[str, Any] = {"check_every": 0, "measure": measure, **more}
    return plan_of(Request(scenario=scenario, vary=vary, **given), FORMS)


def numbers(outcome: SweepOutcome) -> list[Any]:
    return [(r.number, r.point, r.status, r.measures, r.passed) for r in outcome.results]


def test_workers_give_what_one_process_gives(scenario: Path, tmp_path: Path) -> None:
    here = run_sweep(plan(scenario, seeds=3), tmp_path / "here", workers=0)
    there = run_sweep(plan(scenario, seeds=3), tmp_path / "there", workers=2)
    assert numbers(here) == numbers(there)
    assert len(here.results) == 3 * GAINS
    assert all(result.is_good for result in here.results)
    assert here.results[0].measures["part.value max"] > 0


def test_a_crash_costs_one_run(scenario: Path, tmp_path: Path, counted: Path) -> None:
    made = plan(scenario, ends=(0, 1), gains=30)
    deadly = replace(made, points=tuple((gain, int(gain == 7)) for gain in range(1, 31)))
    outcome = run_sweep(deadly, tmp_path / "out", workers=2)
    statuses = Counter(result.status for result in outcome.results)
    assert statuses == {"good": 29, "crashed": 1}
    (crashed,) = outcome.failures
    assert crashed.point == (7, 1)
    assert crashed.message == (
        "part crashed (SIGSEGV: segmentation fault) in a method of its class at tick 5 "
        "(0.00488281 s); it was tried 2 times."
    )
    runs = Counter(line.split()[0] for line in counted.read_text().splitlines())
    assert runs.pop("7.0") == 2
    # What a dying worker had not begun is given to another: nothing is run twice to its end.
    assert set(runs.values()) == {1}


@pytest.mark.parametrize("workers", ["1", "2"])
@pytest.mark.parametrize("call", ["Instantiate", "DoStep"])
def test_an_fmu_that_ends_its_process_with_0_never_passes(
    tmp_path: Path, call: str, workers: str
) -> None:
    command(tmp_path, dying(tmp_path, 3, call, "exit(0)"))
    arguments = ["sweep", "test.yaml", "--vary", "hand.mass=0.2,0.3", "--workers", workers]
    run = "from cosim.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", run, *arguments, "--out", "out", "--no-figure"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stdout
    assert f"box ended the process (exit status 0) {sentence(call, 3)[0].partition(';')[0]}" in (
        done.stdout + done.stderr
    )


def test_a_command_never_runs_in_its_own_process(scenario: Path) -> None:
    """There an FMU that calls ``exit(0)`` would end it with success."""
    run = "from cosim.cli import main; main()"
    arguments = ["sweep", str(scenario), "--vary", "part.gain=1,2", "--workers", "0"]
    done = subprocess.run([sys.executable, "-c", run, *arguments], capture_output=True, check=False)
    assert done.returncode == 2
    assert b"--workers" in done.stderr


def test_a_run_without_end_is_ended(scenario: Path, tmp_path: Path) -> None:
    made = plan(scenario, ends=(0, 2), gains=2)
    outcome = run_sweep(made, tmp_path / "out", workers=2, timeout=1.5)
    assert Counter(result.status for result in outcome.results) == {"good": 2, "crashed": 2}
    assert all("SIGKILL" in result.message for result in outcome.failures)


def test_a_sweep_that_was_killed_goes_on(scenario: Path, tmp_path: Path, counted: Path) -> None:
    whole = run_sweep(plan(scenario, gains=200), tmp_path / "whole", workers=2)
    counted.unlink()
    out = tmp_path / "killed"
    arguments = ["sweep", str(scenario), "--vary", "part.gain=1..200", "--vary", "part.ends=0"]
    arguments += ["--measure", "hand.position:max", "--measure", "hand.position:rms"]
    arguments += ["--measure", "part.value:max", "--check-every", "0", "--no-figure"]
    arguments += ["--workers", "2", "--out", str(out)]
    process = subprocess.Popen(
        [sys.executable, "-c", "from cosim.cli import main; main()", *arguments],
        stdout=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
    )
    results = out / RESULTS_FILE
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (
        results.exists() and len(results.read_bytes().splitlines()) > 20
    ):
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = len(results.read_bytes().splitlines())
    assert 20 < before < 200
    with results.open("a") as file:
        file.write('{"number": 3, "cut')
    again = run_sweep(plan(scenario, gains=200), out, workers=2)
    assert numbers(again) == numbers(whole)
    assert again.reused == before
    begun = Counter(line.split()[0] for line in counted.read_text().splitlines())
    # Only what was under way when it was killed was begun again.
    assert sum(begun.values()) - 200 <= 4
    assert set(begun) == {f"{gain}.0" for gain in range(1, 201)}


def test_a_worker_that_is_killed_from_outside_costs_nothing(scenario: Path, tmp_path: Path) -> None:
    made = plan(scenario, gains=150)
    whole = run_sweep(made, tmp_path / "whole", workers=0)
    from cosim.sweep.work.pool import LocalPool

    pool = LocalPool(made.job, 2)
    killed = False

    def follow(step: Any) -> None:
        nonlocal killed
        if step.done == 40 and not killed:
            killed = True
            os.kill(pool.processes[0], signal.SIGKILL)

    outcome = run_sweep(made, tmp_path / "out", pool=pool, follow=follow)
    assert killed
    assert numbers(outcome) == numbers(whole)


def test_what_is_known_is_not_run_again(scenario: Path, tmp_path: Path, counted: Path) -> None:
    out = tmp_path / "out"
    run_sweep(plan(scenario), out, workers=0)
    first = len(counted.read_text().splitlines())
    grown = run_sweep(plan(scenario, gains=GAINS + 3), out, workers=0)
    assert len(counted.read_text().splitlines()) == first + 3
    assert grown.reused == GAINS
    assert len(grown.results) == GAINS + 3
    # What counts is content, not where a point stands: one is put before the others.
    before = replace(made := plan(scenario), points=((-1, 0), *made.points))
    assert run_sweep(before, out, workers=0).reused == GAINS
    assert len(counted.read_text().splitlines()) == first + 4
    # Another scenario shares nothing.
    changed = plan(scenario, sets=["components.hand.parameters.mass=0.3"])
    assert run_sweep(changed, out, workers=0).reused == 0


@pytest.mark.parametrize("which", ["table", "trace"])
def test_a_file_of_another_content_is_another_sweep(
    scenario: Path, tmp_path: Path, which: str
) -> None:
    """Whatever the numbers depend on, by what is in it."""
    table, trace = tmp_path / "hand.csv", tmp_path / "trace.txt"
    table.write_text("t,x\n0,1\n")
    trace.write_text("1 ms\n2 ms\n")
    sets = [
        f"components.file={{table: {table}, rate: 1024}}",
        f"channels.lan.trace={trace}",
        "channels.lan.each_way_delay=~",
    ]
    out = tmp_path / "out"
    assert run_sweep(plan(scenario, sets=sets), out, workers=0).reused == 0
    assert run_sweep(plan(scenario, sets=sets), out, workers=0).reused == GAINS
    table.write_text(f"t,x\n0,{1 + (which == 'table')}\n")
    trace.write_text(f"1 ms\n{2 + (which == 'trace')} ms\n")
    assert run_sweep(plan(scenario, sets=sets), out, workers=0).reused == 0


def test_a_file_that_one_value_names_is_that_values_content(scenario: Path, tmp_path: Path) -> None:
    """What another value than the first stands for is read, too; what was not there may come."""
    one, other = tmp_path / "one.txt", tmp_path / "other.txt"
    one.write_text("1 ms\n2 ms\n")
    sets = [f"channels.lan.trace={one}", "channels.lan.each_way_delay=~", "components.part=~"]
    request = Request(
        scenario=scenario,
        sets=[*sets, "channels.lan.round_trip_delay=~"],
        vary={"lan.trace": [str(one), str(other)], "push.amplitude": [1, 2]},
        measure={"hand.position": "rms"},
    )
    out = tmp_path / "out"
    statuses = [each.status for each in run_sweep(plan_of(request, FORMS), out, workers=0).results]
    assert statuses == ["good", "good", "refused", "refused"]
    other.write_text("3 ms\n")
    found = run_sweep(plan_of(request, FORMS), out, workers=0)
    assert {each.status for each in found.results} == {"good"}
    assert found.reused == 2
    other.write_text("5 ms\n")
    later = run_sweep(plan_of(request, FORMS), out, workers=0)
    assert later.reused == 2
    assert later.results[2].measures != found.results[2].measures
    assert run_sweep(plan_of(request, FORMS), out, workers=0).reused == 4


def test_a_line_that_is_no_result_is_named(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_sweep(plan(scenario), out, workers=0)
    for line in ("nonsense", "[1]", '{"number": 1}', '{"point": [], "colour": 1}'):
        whole = (out / RESULTS_FILE).read_text()
        (out / RESULTS_FILE).write_text(f"{whole}{line}\n")
        with pytest.raises(InputError, match=rf"{RESULTS_FILE}:{GAINS + 1}: this is no result"):
            run_sweep(plan(scenario), out, workers=0)
        (out / RESULTS_FILE).write_text(whole)


def test_what_no_process_can_keep_is_refused(scenario: Path, tmp_path: Path) -> None:
    made = plan(scenario)
    with pytest.raises(InputError, match="-1 processes are none"):
        run_sweep(made, tmp_path, workers=-1)
    with pytest.raises(InputError, match="only a run in another process"):
        run_sweep(made, tmp_path, workers=0, timeout=1.0)
    with pytest.raises(InputError, match="no time that a run may take"):
        run_sweep(made, tmp_path, timeout=0.0)


def test_a_component_that_remembers_is_found_out(tmp_path: Path) -> None:
    part = {**SCENARIO["components"]["part"], "python": "tests.support.sweep.parts:Forgets"}
    components = {**SCENARIO["components"], "part": part}
    path = tmp_path / "test.yaml"
    path.write_text(json.dumps({**SCENARIO, "components": components}))
    outcome = run_sweep(plan(path, check_every=5), tmp_path / "out", workers=0)
    assert {result.status for result in outcome.results} == {"good", "error"}
    assert "keeps something from run to run" in outcome.failures[0].message


def test_a_run_that_begins_in_the_middle_is_the_whole_run(scenario: Path, tmp_path: Path) -> None:
    sets = ["components.part=~"]
    vary = {"lan.loss": "0.2, 0.2000001"}
    expected = plan_of(
        Request(scenario=scenario, vary=vary, sets=sets, measure={"hand.position": "rms"}), FORMS
    )
    branched = plan_of(
        Request(
            scenario=scenario,
            vary={**vary},
            sets=sets,
            start="10/1024 s",
            measure={"hand.position": "rms"},
        ),
        FORMS,
    )
    plain = run_sweep(expected, tmp_path / "plain", workers=0)
    middle = run_sweep(branched, tmp_path / "middle", workers=0)
    assert [r.measures for r in middle.results] == [r.measures for r in plain.results]
    assert all(r.is_good for r in middle.results)


def test_what_comes_before_the_start_is_that_of_the_scenario_whoever_runs_first(
    scenario: Path, tmp_path: Path
) -> None:
    made = plan_of(
        Request(
            scenario=scenario,
            seeds=4,
            sets=["components.part=~", "channels.lan.loss=0.5", "duration=0.25"],
            start="64/1024 s",
            check_every=1,
            measure={"hand.position": "rms"},
        ),
        FORMS,
    )
    forwards = run_sweep(made, tmp_path / "forwards", workers=0)
    assert all(result.checked for result in forwards.results)
    assert len({result.measures["hand.position rms"] for result in forwards.results}) > 1
    with PointRunner(made.job) as runner:
        last_first = [runner.run(Task(n, made.points[n])) for n in (3, 2, 1, 0)]
    assert [r.measures for r in reversed(last_first)] == [r.measures for r in forwards.results]


def test_another_order_of_computation_cannot_begin_in_the_middle(
    scenario: Path, tmp_path: Path
) -> None:
    made = plan_of(
        Request(
            scenario=scenario,
            vary={"lan.round_trip_delay": [2, 0]},
            sets=["components.part=~"],
            start="10/1024 s",
        ),
        FORMS,
    )
    outcome = run_sweep(made, tmp_path / "out", workers=0)
    assert [result.status for result in outcome.results] == ["good", "refused"]
    assert "in another order than" in outcome.results[1].message


def test_what_counts_from_the_first_tick_cannot_begin_in_the_middle(
    scenario: Path, tmp_path: Path
) -> None:
    made = plan_of(
        Request(
            scenario=scenario,
            vary={"hand.mass": [0.2, 0.4]},
            sets=["components.part=~"],
            start="10/1024 s",
        ),
        FORMS,
    )
    outcome = run_sweep(made, tmp_path / "out", workers=0)
    assert outcome.results[-1].status == "refused"
    assert "which count from tick 0" in outcome.results[-1].message


def test_a_folder_of_something_else_is_refused(scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no sweep"):
        run_sweep(plan(scenario), tmp_path, workers=0)
