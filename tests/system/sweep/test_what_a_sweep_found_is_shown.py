"""A boundary is run where it is, the picture is what the variables ask for, failures are listed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.cli import cli
from cosim.reading import FORMS
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.results import figures
from cosim.sweep.results.map_panel import panel_of
from cosim.sweep.sweep import SweepOutcome, run_sweep
from cosim.sweep.theory import is_stable
from tests.support.sweep.parts import SCENARIO
from tests.support.sweep.written import table_in

SHAPE = (17, 17)
LOOP: dict[str, Any] = {
    "scenario": "single_axis_distributed",
    "vary": {
        "lan.round_trip_delay": f"0..{SHAPE[0] - 1}",
        "k": {
            "set": ["coupler_12.stiffness", "coupler_21.stiffness"],
            "values": f"50 N/m..4000 N/m/{SHAPE[1]} log",
        },
    },
    "sets": ["duration=2 s", "components.step_1.parameters.duration=0.2"],
    "expect": {"coupler_11.force": {"growth_below": 0, "from": 0.5}},
    "check_every": 0,
}


def swept(out: Path, **request: Any) -> SweepOutcome:
    return run_sweep(plan_of(Request(**request), FORMS), out, workers=0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> SweepOutcome:
    return swept(tmp_path_factory.mktemp("whole") / "out", **LOOP)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures that would have been saved."""
    made: list[Any] = []
    monkeypatch.setattr(figures, "save", lambda figure, file: made.append(figure))
    return made


def test_a_boundary_takes_few_runs_and_fills_in_the_rest(
    whole: SweepOutcome, tmp_path: Path
) -> None:
    found = swept(tmp_path / "out", **LOOP, boundary=True)
    assert len(found.results) < 0.6 * len(whole.results)
    assert found.verdicts == {each.number: each.is_good for each in whole.results}
    assert 0 < sum(found.verdicts.values()) < len(found.verdicts)
    # Its picture has a colour in every cell, the whole grid's.
    axes = found.plan.axes
    np.testing.assert_array_equal(panel_of(found, *axes).shares, panel_of(whole, *axes).shares)


def test_a_map_has_the_theorys_boundary_laid_over_it(
    whole: SweepOutcome, drawn: list[Any], tmp_path: Path
) -> None:
    whole.plot(tmp_path / "map.png")
    [figure] = drawn
    plot = figure.axes[0]
    assert (plot.get_xscale(), plot.get_yscale()) == ("linear", "log")
    assert (plot.get_xlabel(), plot.get_ylabel()) == ("lan.round_trip_delay", "k (N/m)")
    mesh, line = plot.collections
    good = np.array([each.is_good for each in whole.results], dtype=float).reshape(SHAPE)
    np.testing.assert_array_equal(mesh.get_array().reshape(SHAPE[::-1]), good.T)
    assert [text.get_text() for text in plot.get_legend().get_texts()] == [
        "theory: spectral radius 1"
    ]
    assert whole.theory is not None
    stable = np.array([is_stable(radius) for radius in whole.theory]).reshape(SHAPE)
    for delay, stiffness in np.concatenate(line.get_paths()[0].to_polygons(closed_only=False)):
        column = stable[round(float(delay))]
        below = np.geomspace(50, 4000, SHAPE[1])[column]
        assert below.max(initial=0) <= stiffness * 1.8, "it parts what is stable from what is not"
    assert whole.disagreements is not None
    assert whole.disagreements <= 0.02 * stable.size


def test_seeds_are_a_histogram_and_samples_are_points(drawn: list[Any], tmp_path: Path) -> None:
    file = tmp_path / "test.yaml"
    file.write_text(json.dumps(SCENARIO))
    given: dict[str, Any] = {"scenario": file, "measure": {"part.value": ["max", "mean"]}}
    seeds = swept(tmp_path / "seeds", **given, seeds=12)
    seeds.plot()
    plot = drawn[0].axes[0]
    assert plot.get_title(loc="left") == "part.value max"
    assert sum(bar.get_height() for bar in plot.patches) == 12
    assert plot.get_ylabel() == "runs"

    vary = {"part.gain": "1..5", "push.amplitude": "0..2/2"}
    sampled = swept(tmp_path / "sample", **given, vary=vary, sample="sobol", points=16)
    sampled.plot()
    good, _ = drawn[1].axes[0].lines
    assert len(good.get_xdata()) == 16
    assert sorted(good.get_ydata()) == sorted(float(each.point[1]) for each in sampled.results)

    line = swept(tmp_path / "line", **given, vary={"push.amplitude": "0..2/5"})
    line.plot()
    assert [list(each.get_xdata()) for each in drawn[2].axes[0].lines] == [[0, 0.5, 1, 1.5, 2], []]


def test_the_command_lists_what_is_not_good(tmp_path: Path) -> None:
    file = tmp_path / "test.yaml"
    file.write_text(json.dumps(SCENARIO))
    arguments = ["sweep", str(file), "--vary", "part.gain=1..20", "--workers", "1", "--no-figure"]
    arguments += ["--expect", "part.value:max_below=110", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert lines[0] == "20 runs: 5 good, 15 failed"
    listed = [line for line in lines if line.startswith("  failed")]
    assert listed[0].startswith("  failed   part.gain = 6: part.value: max_below 110, measured 124")
    assert len(listed) == 10
    assert "  and 5 more" in lines
    again = CliRunner().invoke(cli, [*arguments, "--json"])
    said = json.loads(again.stdout)
    assert (said["runs"], said["reused"]) == (20, 20)
    assert [each["point"] for each in said["failures"]] == [[gain] for gain in range(6, 21)]
    table = table_in(tmp_path / "out")
    assert [row["part.gain"] for row in table] in ([*range(1, 21)], [*map(str, range(1, 21))])
    assert [str(row["part.value max_below met"]).lower() for row in table] == (
        ["true"] * 5 + ["false"] * 15
    )
