"""``cohaptic run`` records, summarises and says how it ended, in files and in its exit status."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path

import click
import pytest

from cosim.base.errors import InputError
from cosim.cli.run import command
from cosim.record import digest, open_run
from cosim.scenario import load
from tests.support.command import COHAPTIC, cohaptic
from tests.support.record.synthetic_run import small_disk

SCENARIO = Path(__file__).parents[2] / "support" / "record" / "single_axis.yaml"


def test_a_run_leaves_its_record_its_manifest_and_the_scenario_that_ran(tmp_path: Path) -> None:
    first = cohaptic("run", str(SCENARIO), "--set", "seed=5", folder=tmp_path)
    assert (first.returncode, first.stderr) == (0, "")
    assert "1 of 1 expectations met" in first.stdout
    folder = tmp_path / "runs" / "single_axis-1"
    assert {path.name for path in folder.iterdir()} == {
        "manifest.json",
        "overview.png",
        "run.h5",
        "scenario.resolved.yaml",
        "report.html",
        "scene.json",
        "summary.json",
    }
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["exit"] == {"status": 0, "message": "", "ticks": 1024}
    assert manifest["scenario"]["seed"] == 5
    assert len(manifest["components"]["hand"]["sha256"]) == 64
    assert load(folder / "scenario.resolved.yaml").seed == 5

    # What is written is enough to do it again, bit for bit, in the next folder.
    again = cohaptic("run", str(folder / "scenario.resolved.yaml"), "--json", folder=tmp_path)
    summary = json.loads(again.stdout)
    assert summary["ticks"] == 1024
    assert summary["real_time_factor"] == pytest.approx(1 / summary["wall_time"])
    with open_run(folder) as one, open_run(tmp_path / summary["run"]) as other:
        assert digest(one) == digest(other)
        assert {group.rate for group in one.groups.values()} == {1024, 32}


def test_an_expectation_that_is_not_met_fails_the_run(tmp_path: Path) -> None:
    done = cohaptic(
        "run",
        str(SCENARIO),
        "--set",
        "expect={box.position: {max_below: 1 mm, min_above: -1}}",
        "--no-figure",
        "--json",
        folder=tmp_path,
    )
    assert done.returncode == 1
    summary = json.loads(done.stdout)
    assert summary["passed"] is False
    assert [verdict["passed"] for verdict in summary["expectations"]] == [True, False, True]
    assert summary["failures"][0].startswith("box.position: max_below 0.001 m, measured ")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--set", "expect={box.position: {max_bellow: 1}}"], "Did you mean max_below"),
        (["--set", "components.hand.parameters.mas=1"], "mas"),
        (["--out", "taken"], "not empty"),
        (["--out", "taken/file"], "is a file"),
        (["--duration", "soon"], "soon"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing_behind(
    arguments: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "file").write_text("mine")
    monkeypatch.chdir(tmp_path)
    with pytest.raises((InputError, click.BadParameter)) as refused:
        command.main([str(SCENARIO), *arguments], standalone_mode=False)
    assert told in str(refused.value)
    status = getattr(refused.value, "exit_status", None) or getattr(refused.value, "exit_code", 0)
    assert status == 2
    assert {path.name for path in tmp_path.rglob("*")} == {"taken", "file"}


def rows_so_far(folder: Path) -> int:
    """Reads along while the run goes on."""
    try:
        with open_run(folder) as run:
            return run.groups["control"].rows
    except (InputError, KeyError):
        return 0


def test_ctrl_c_leaves_a_valid_record_and_says_where_it_stopped(tmp_path: Path) -> None:
    arguments = ["run", str(SCENARIO), "--duration", "2000", "--out", "cut", "--no-figure"]
    with subprocess.Popen(
        [*COHAPTIC, *arguments], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        while rows_so_far(tmp_path / "cut") == 0 and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate()
    assert process.returncode == 1
    assert b"Traceback" not in errors
    assert errors.startswith(b"Interrupted at tick")
    assert b"what was reached is in cut" in output
    with open_run(tmp_path / "cut") as run:
        reached = run.manifest["exit"]["ticks"]
        assert 0 < reached < 20000 * 1024
        group = run.groups["control"]
        assert group.rows == group.capacity == reached
        assert run["box.position"].values[-1] != 0


def test_a_failing_component_ends_the_run_with_its_name_and_what_was_reached(
    tmp_path: Path,
) -> None:
    scenario = tmp_path / "unstable.yaml"
    text = SCENARIO.read_text().replace("stiffness: 1000", "stiffness: 1e9")
    scenario.write_text(text.replace("duration: 1\n", "duration: 100\n"))
    done = cohaptic("run", str(scenario), "--no-figure", folder=tmp_path)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    with open_run(tmp_path / "runs" / "unstable-1") as run:
        assert run.manifest["exit"]["status"] == 1
        assert done.stderr == run.manifest["exit"]["message"] + "\n"
        assert 0 < run.groups["control"].rows < 100 * 1024


FILLS_THE_DISK = """
from pathlib import Path
from cosim.base.component import Component


class Greedy(Component):
    @property
    def variables(self):
        return ()

    def initialise(self, setup, inputs, outputs):
        pass

    def step(self, tick):
        if tick == 20_000:
            with Path("other").open("wb", buffering=0) as file:
                while file.write(bytes(1 << 16)):
                    pass
"""


def test_a_full_disk_ends_the_run_with_one_sentence_and_a_record(tmp_path: Path) -> None:
    greedy = '  greedy: {python: "fills:Greedy", rate: control}\n'
    text = SCENARIO.read_text().replace("components:\n", f"components:\n{greedy}", 1)
    with small_disk(tmp_path, "32m"):
        (tmp_path / "fills.py").write_text(FILLS_THE_DISK)
        (tmp_path / "single_axis.yaml").write_text(text)
        done = cohaptic("run", "single_axis.yaml", "--duration", "100", folder=tmp_path)
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
        assert "No space left on device" in done.stderr
        with open_run(tmp_path / "runs" / "single_axis-1") as run:
            assert 1000 < run.groups["control"].rows < 100 * 1024
            assert run["box.position"].values[-1] != 0


def test_a_record_larger_than_the_disk_is_refused_with_both_sizes(tmp_path: Path) -> None:
    with small_disk(tmp_path, "4m"):
        done = cohaptic("run", str(SCENARIO), "--duration", "600", folder=tmp_path)
        assert done.returncode == 2
        assert "MB are free at" in done.stderr
        assert "record fewer signals" in done.stderr
        assert len(done.stderr.splitlines()) == 1
        assert not (tmp_path / "runs").exists()
