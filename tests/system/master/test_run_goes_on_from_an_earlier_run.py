"""``cohaptic run --from``: the new record is whole, and a run that is another one fails."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from cosim.record.digest import digest
from cosim.record.reader import RUN_FILE, SCENARIO_FILE, open_run
from tests.support.fmus.foreign import foreign_fmu, scalar

SCENARIO = "single_axis_distributed"


def cohaptic(*words: str | Path) -> subprocess.CompletedProcess[str]:
    command = [
        sys.executable,
        "-c",
        "from cosim.cli import main; main()",
        "run",
        *map(str, words),
        "--no-figure",
    ]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def digest_of(folder: Path) -> str:
    with open_run(folder) as run:
        return digest(run)


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run") / "earlier"
    done = cohaptic(SCENARIO, "--duration", "0.5", "--snapshot", "0.25s", "--out", out)
    assert done.returncode == 0, done.stderr
    assert (out / "snapshot-256").is_file()
    return out


@pytest.mark.parametrize(
    ("time", "sentence"),
    [
        ("0.25s", "Ticks 256 to 511 are those of"),
        ("0.125s", "no snapshot of tick 128"),
    ],
)
def test_the_record_is_that_of_a_run_without_interruption(
    earlier: Path, tmp_path: Path, time: str, sentence: str
) -> None:
    done = cohaptic("--from", f"{earlier}@{time}", "--duration", "0.75", "--out", tmp_path / "on")
    assert done.returncode == 0, done.stderr
    assert sentence in done.stderr
    assert cohaptic(SCENARIO, "--duration", "0.75", "--out", tmp_path / "whole").returncode == 0
    assert digest_of(tmp_path / "on") == digest_of(tmp_path / "whole")


def test_a_run_that_is_another_one_fails(earlier: Path, tmp_path: Path) -> None:
    """Computed again with another force, it is told where it first differs."""
    other = tmp_path / "other"
    other.mkdir()
    (other / RUN_FILE).write_bytes((earlier / RUN_FILE).read_bytes())
    text = (earlier / SCENARIO_FILE).read_text()
    assert "amplitude: 1.0" in text
    (other / SCENARIO_FILE).write_text(text.replace("amplitude: 1.0", "amplitude: 1.5"))
    done = cohaptic("--from", f"{other}@0.25s", "--out", tmp_path / "on")
    assert done.returncode == 1
    assert "This run is not" in done.stderr
    assert "has another value at tick 103 (" in done.stderr

    (other / "snapshot-256").write_bytes((earlier / "snapshot-256").read_bytes())
    done = cohaptic("--from", f"{other}@0.25s", "--out", tmp_path / "refused")
    assert done.returncode == 2
    assert "step_1 had other parameters" in done.stderr
    assert not (tmp_path / "refused").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "Name a scenario"),
        ((SCENARIO, "--from", "{run}@0.25s"), "and not both"),
        (("--from", "{run}"), "--from takes a run's folder and a time"),
        (("--from", "{run}@soon"), "'soon' is not a time"),
        (("--from", "{run}@-1s"), "lies before the run"),
        (("--from", "{run}@0.2501s"), "lies between two ticks"),
        (("--from", "{run}@0.75s"), "was recorded up to tick 512, not to tick 768"),
        (("--from", "{run}@0.25s", "--set", "seed=2"), "leave --set and --with out"),
        (("--from", "{run}@0.25s", "--duration", "0.125"), "the run ends at tick 128"),
        (("--from", "{run}@0.25s", "--realtime"), "leave --realtime out"),
        (("--from", "nowhere@0.25s"), "nowhere is no run's folder"),
        ((SCENARIO, "--duration", "0.5", "--snapshot", "1s"), "lies behind the run's end, 0.5 s"),
    ],
)
def test_what_does_not_go_together(
    earlier: Path, tmp_path: Path, words: tuple[str, ...], sentence: str
) -> None:
    done = cohaptic(*(word.format(run=earlier) for word in words), "--out", tmp_path / "out")
    assert done.returncode == 2, done.stderr
    assert sentence in done.stderr
    assert not (tmp_path / "out").exists()


DIES = """
    void exit(int);
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "%s") && (m->time > 2.5 || is(call, "Terminate")))
            exit(0);
        return 0;
    }
    #define HOOK hook
    EXPORT int fmi3GetFMUState(Foreign *m, void **state) { *state = m; return 0; }
    EXPORT int fmi3SetFMUState(Foreign *m, void *state) { return 0; }
    EXPORT int fmi3FreeFMUState(Foreign *m, void **state) { *state = 0; return 0; }
    EXPORT int fmi3SerializedFMUStateSize(Foreign *m, void *state, size_t *size)
    { *size = 8; return 0; }
    EXPORT int fmi3SerializeFMUState(Foreign *m, void *state, char *bytes, size_t size)
    { return 0; }
    EXPORT int fmi3DeserializeFMUState(Foreign *m, const char *bytes, size_t size, void **state)
    { *state = m; return 0; }
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the sentences are Linux's")
@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("Terminate", "in fmi3Terminate at tick 8 (8 s); the record is complete"),
        ("DoStep", "in its step at tick 3 (3 s); what was written before is kept"),
    ],
)
def test_an_fmu_that_dies_after_a_snapshot_is_told_of_as_ever(
    tmp_path: Path, call: str, said: str
) -> None:
    """The record is finished before FMUs are freed, and the calls for the state are over."""
    fmu = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "u", 1, causality="input", start="0"),
        snippet=DIES % call,
        interface={"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
    )
    scenario = tmp_path / "s.yaml"
    scenario.write_text(
        f"cohaptic: 1\nduration: 8\nbase_rate: 1\ncomponents: {{box: {{fmu: {fmu}, rate: 1}}}}\n"
        "record: [box.u]\n"
    )
    done = cohaptic(scenario, "--snapshot", "2 s", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert f"box ended the process (exit status 0) {said}" in done.stderr
    assert (tmp_path / "out" / "snapshot-2").is_file()
    with open_run(tmp_path / "out") as run:
        assert run.ticks == 8 if "complete" in said else run.ticks <= 3
