"""A run from 10 s on has the values of one from 0 on, and everybody tells its times as its own."""

from __future__ import annotations

import csv
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.plot.kinds import difference, over_time
from cosim.plot.series import Span, select
from cosim.reading import load
from cosim.record.reader import open_run
from cosim.render.poses import frame_ticks
from cosim.report.target import parse_target
from cosim.report.window import MEASURES, measure
from cosim.run import run_scenario
from cosim.scenario import Scenario
from cosim.sweep.ask import sweep
from cosim.sweep.theory import spectral_radius

SCENARIO, START = "single_axis_distributed", 10
SHORT = ("duration=0.25 s",)
LATE = (*SHORT, f"start_time={START} s", "components.step_1.parameters.start_time=10.1")
"""The same motion, ten seconds later."""


def loaded(*sets: str) -> Scenario:
    return load(SCENARIO, sets=sets)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for name, sets in (("soon", SHORT), ("late", LATE)):
        run_scenario(loaded(*sets), folder / name, figure=False)
    other = "components.object_1.parameters.mass=0.5"
    run_scenario(loaded(*LATE, other), folder / "heavier", figure=False)
    return folder


def cohaptic(*words: object, status: int = 0) -> str:
    done = CliRunner().invoke(cli, [str(word) for word in words])
    assert done.exit_code == status, (done.output, done.exception)
    return done.output


def test_values_and_measures_are_those_of_the_run_from_0_on(folder: Path) -> None:
    with open_run(folder / "soon") as soon, open_run(folder / "late") as late:
        for name, signal in soon.signals.items():
            np.testing.assert_array_equal(signal.values, late[name].values)
            np.testing.assert_array_equal(signal.group.time + START, late[name].group.time)
            units = {each: other.unit for each, other in soon.signals.items()}
            target = parse_target(name, units)
            windows = [measure(run, target, 128, 256) for run in (soon, late)]
            for what, function in MEASURES.items():
                one, other = map(function, windows)
                assert one == pytest.approx(other, nan_ok=True), (name, what)


def test_another_start_is_another_run(folder: Path) -> None:
    text = cohaptic("compare", folder / "soon", folder / "late", status=1)
    assert "start: tick 0 → tick 10240" in text
    assert "no value is compared" in text


def test_a_difference_is_told_at_its_time(folder: Path, tmp_path: Path) -> None:
    found = json.loads(cohaptic("compare", folder / "late", folder / "heavier", "--json", status=1))
    tick = found["signals"][0]["tick"]
    text = cohaptic(
        "compare", folder / "late", folder / "heavier", "--figure", tmp_path / "a.png", status=1
    )
    assert f"at tick {tick} (t = {START + tick / 1024:g} s)" in text


def test_it_is_replayed_and_gone_on_with(folder: Path, tmp_path: Path) -> None:
    assert "all 256 ticks are the same" in cohaptic("replay", folder / "late")
    out = tmp_path / "on"
    words = ("run", "--from", f"{folder / 'late'}@10.125s", "--duration", "0.3", "--out", out)
    cohaptic(*words, "--no-figure")
    with open_run(folder / "late") as earlier, open_run(out) as later:
        assert (later.ticks, later.span[0]) == (308, START)
        for name, signal in earlier.signals.items():
            rows = signal.group.rows
            np.testing.assert_array_equal(later[name].values[:rows], signal.values)
    before = CliRunner().invoke(
        cli, ["run", "--from", f"{folder / 'late'}@0.125s", "--out", str(tmp_path / "no")]
    )
    assert "0.125s lies before the run" in str(before.exception)


def test_a_snapshot_is_left_at_its_time(tmp_path: Path) -> None:
    words = [word for text in LATE for word in ("--set", text)]
    out = tmp_path / "out"
    cohaptic("run", SCENARIO, *words, "--snapshot", "10.125s", "--out", out, "--no-figure")
    assert (out / "snapshot-128").is_file()


def test_an_interruption_is_told_at_its_time(tmp_path: Path) -> None:
    def interrupted(simulation, recorder, progress) -> None:
        def stop() -> None:
            raise KeyboardInterrupt

        simulation.run(recorder, pauses={128: stop}, keep_fmus=True)

    finished = run_scenario(loaded(*LATE), tmp_path / "run", execute=interrupted, figure=False)
    assert "at tick 128 of 256 (t = 10.125 s)" in finished.summary.content["message"]


def test_exports_have_its_times(folder: Path, tmp_path: Path) -> None:
    part = ("--from", "10.125 s", "--until", "10.2 s")
    cohaptic("record", "export", folder / "late", "--format", "csv", "--out", tmp_path, *part)
    rows = list(csv.reader((tmp_path / "control.csv").read_text("utf-8").splitlines()))[2:]
    assert float(rows[0][1]) == 10.125
    assert float(rows[-1][1]) == int(10.2 * 1024) / 1024


def test_figures_have_its_times(folder: Path) -> None:
    name = "hand_1.position"
    with open_run(folder / "late") as late, open_run(folder / "soon") as soon:
        (panel,) = over_time(select([late], [name]), Span())
        np.testing.assert_array_equal(panel.lines[0].x, late[name].group.time)
        (panel,) = over_time(select([late], [name]), Span(Fraction("10.125"), Fraction("10.2")))
        assert (panel.lines[0].x[0], panel.lines[0].x[-1]) == (10.125, int(10.2 * 1024) / 1024)
        with pytest.raises(InputError, match="has no row from 0 s to 1 s"):
            over_time(select([late], [name]), Span(Fraction(0), Fraction(1)))
        with pytest.raises(InputError, match="no moment in common"):
            difference(select([late, soon], [name]), Span())


def test_pictures_begin_with_its_first_tick(folder: Path) -> None:
    with open_run(folder / "late") as run:
        ticks = frame_ticks(run, Fraction(10), Fraction("10.25"), Fraction(1, 8))
    assert ticks == [0, 128, 255]


def test_a_playback_of_another_start_is_refused(folder: Path, tmp_path: Path) -> None:
    play = f"components.step_1={{playback: '{folder / 'late'}', station: station_1}}"
    again = run_scenario(loaded(*LATE[:2], play), tmp_path / "again", figure=False)
    assert again.error is None
    with pytest.raises(InputError, match=r"recorded from 10 s on .* starts at 0 s; .*start_time"):
        run_scenario(loaded(*SHORT, play), tmp_path / "other", figure=False)


def test_a_sweep_begins_at_its_time(tmp_path: Path) -> None:
    outcomes = [
        sweep(
            SCENARIO,
            {"channels.lan.loss": [0.1, 0.2]},
            sets=sets,
            measure={"hand_1.position": ["final", "growth"]},
            start=start,
            workers=1,
            out=tmp_path / name,
        ).to_dataframe()
        for name, sets, start in (("a", SHORT, "0.125 s"), ("b", LATE, "10.125 s"))
    ]
    measured = [name for name in outcomes[0].columns if "hand_1" in name]
    assert measured
    for name in measured:
        assert outcomes[0][name].tolist() == pytest.approx(outcomes[1][name].tolist())
    with pytest.raises(InputError, match=r"0.25 s from 10 s on"):
        sweep(SCENARIO, {"channels.lan.loss": [0.1]}, sets=LATE, start="0.125 s", workers=1)


def test_the_theory_does_not_ask_when_it_starts() -> None:
    assert spectral_radius(loaded(*SHORT)) == spectral_radius(loaded(*LATE))
