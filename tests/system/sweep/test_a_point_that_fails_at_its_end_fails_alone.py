"""An FMU that fails when it is terminated or freed: that point, that run, that scenario alone.

Whoever comes next in the same process is none the worse: another point of a sweep, another scenario
of one call, another ``cohaptic.run``, and a replay says what it met itself.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import cohaptic
from cosim.reading import FORMS
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.sweep import run_sweep
from tests.support.fmus.foreign import foreign_fmu, scalar

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a child needs Linux")
TICKS = 8
END = f"at tick {TICKS} ({TICKS} s)"
WORDS = {"2": "discard", "3": "error", "4": "fatal"}


def scenario(folder: Path, call: str, code: str, version: int = 3, keys: str = "") -> Path:
    """``box`` does ``code`` in a call where its parameter ``p`` is 2; without it, it is 1."""
    snippet = f"""
        void abort(void);
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "{call}") && m->real[2] == 2 && m->time > {0 if call == "DoStep" else -1})
                {code};
            return 0;
        }}
        #define HOOK hook
    """
    variables = scalar(version, "u", 1, causality="input", start="0")
    variables += scalar(version, "p", 2, causality="parameter", variability="fixed", start="1")
    fmu = foreign_fmu(folder, version, variables, snippet=snippet)
    file = folder / "test.yaml"
    file.write_text(
        f"cohaptic: 1\nduration: {TICKS}\nbase_rate: 1\ncomponents:\n  hand: {{fmu: hand, rate: 1}}"
        f"\n  box: {{fmu: {fmu}, rate: 1, feedthrough: true{keys}}}\n"
        "connections: [hand.position -> box.u]\n"
    )
    return file


def statuses(file: Path, out: Path, workers: int) -> list[tuple[str, str]]:
    """Of the points in which ``p`` is 1, 2, 3, 2 and 1.5: what became of them."""
    request = Request(
        scenario=file,
        vary={"box.p": [1, 2, 3, 2, 1.5]},
        measure={"hand.position": "max"},
        check_every=0,
    )
    plan = plan_of(request, FORMS)
    outcome = run_sweep(plan, out, workers=workers, theory=False)
    return [(each.status, each.message) for each in outcome.results]


@pytest.mark.parametrize(
    ("status", "version", "keys"),
    [("2", 2, ""), ("3", 3, ""), ("4", 2, ""), ("4", 3, ""), ("4", 3, ", isolate: process")],
)
def test_a_status_of_terminate_is_its_points_own(
    tmp_path: Path, status: str, version: int, keys: str
) -> None:
    file = scenario(tmp_path, "Terminate", f"return {status}", version, keys)
    found = statuses(file, tmp_path / "out", 0)
    said = f"box returned status '{WORDS[status]}' from fmi{version}Terminate {END}"
    assert found == [("good", ""), ("error", said), ("good", ""), ("error", said), ("good", "")]


@pytest.mark.parametrize("call", ["Terminate", "FreeInstance"])
@pytest.mark.parametrize(("keys", "workers"), [("", 1), (", isolate: process", 0)])
def test_a_death_at_the_end_is_its_points_own(
    tmp_path: Path, call: str, keys: str, workers: int
) -> None:
    file = scenario(tmp_path, call, "abort()", keys=keys)
    found = statuses(file, tmp_path / "out", workers)
    said = f"box crashed (SIGABRT: aborted) in fmi3{call} {END}"
    failed = "error", said
    if workers:
        failed = "crashed", f"{said}; it was tried 2 times."
    assert found == [("good", ""), failed, ("good", ""), failed, ("good", "")]


@pytest.mark.parametrize(
    ("code", "keys", "said"),
    [
        ("return 4", "", "box returned status 'fatal' from its step at tick 1 (1 s)"),
        ("abort()", ", isolate: process", "box crashed (SIGABRT: aborted) in its step"),
    ],
)
def test_what_is_lost_in_a_point_is_made_anew_for_the_next(
    tmp_path: Path, code: str, keys: str, said: str
) -> None:
    file = scenario(tmp_path, "DoStep", code, keys=keys)
    found = statuses(file, tmp_path / "out", 0)
    assert [status for status, _ in found] == ["good", "error", "good", "error", "good"]
    assert said in found[1][1]
    assert said in found[3][1]


@pytest.mark.parametrize(("code", "keys"), [("return 4", ""), ("abort()", ", isolate: process")])
def test_two_runs_of_one_process_and_their_replays(tmp_path: Path, code: str, keys: str) -> None:
    file = scenario(tmp_path, "Terminate", code, keys=keys)
    for number, (p, status) in enumerate([(2, 1), (1, 0)]):
        finished = cohaptic.run(
            file,
            tmp_path / f"run-{number}",
            sets=[f"components.box.parameters={{p: {p}}}"],
            figure=False,
        )
        content = finished.summary.content
        assert (content["status"], content["ticks"]) == (status, TICKS)
        assert ("in fmi3Terminate" in content["message"] or "'fatal'" in content["message"]) is (
            status == 1
        )
    again = cohaptic.resume(tmp_path / "run-0", "3 s", tmp_path / "again", figure=False)
    assert again.summary.content["status"] == 1
    well = cohaptic.resume(tmp_path / "run-1", "3 s", tmp_path / "well", figure=False)
    assert well.summary.content["status"] == 0


def cohaptic_command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", "from cosim.cli import main; main()", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("code", ["return 3", pytest.param("abort()", marks=pytest.mark.slow)])
def test_each_scenario_of_one_call_ends_for_itself(tmp_path: Path, code: str) -> None:
    file = scenario(tmp_path, "Terminate", code)
    text = file.read_text()
    well = text.replace("feedthrough: true", "feedthrough: true, parameters: {p: 1}")
    (tmp_path / "well.yaml").write_text(well)
    file.write_text(text.replace("feedthrough: true", "feedthrough: true, parameters: {p: 2}"))
    names = ("test.yaml", "well.yaml")
    done = cohaptic_command(tmp_path, "run", *names, "--out", "out", "--no-figure")
    assert done.returncode == 1, done.stderr
    contents = [
        json.loads((tmp_path / "out" / folder / "summary.json").read_text())
        for folder in ("test", "well")
    ]
    assert [(each["status"], each["ticks"]) for each in contents] == [(1, 8), (0, 8)]
    assert f"fmi3Terminate {END}; the record is complete." in contents[0]["message"]
    again = cohaptic_command(tmp_path, "replay", "out/test")
    assert again.returncode == 1
    assert f"fmi3Terminate {END}; the record is complete." in again.stdout
    again = cohaptic_command(tmp_path, "replay", "out/well")
    assert again.returncode == 0, again.stderr
