"""A page says what chapters 3 to 6 foretell, what the run did, and why where the theory refuses."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest

from cosim.analysis.worlds import tell_of
from cosim.reading import load
from cosim.record.reader import open_run
from cosim.report.page.foretold import _frequency, foretold_notes, foretold_rows
from cosim.run import run_scenario


def table(folder: Path) -> str:
    text = (folder / "report.html").read_text(encoding="utf-8")
    found = re.search(r'<section aria-labelledby="theory">.*?</section>', text, re.DOTALL)
    assert found
    return html.unescape(found[0])


@pytest.mark.parametrize(
    ("scenario", "verdict"),
    [("two_users_box_centralized", "unstable"), ("single_axis_distributed", "stable")],
)
def test_the_verdict_and_the_measurement_are_in_one_row(
    tmp_path: Path, scenario: str, verdict: str
) -> None:
    sets = ["expect={}", *(["duration=5 s"] if verdict == "unstable" else [])]
    done = run_scenario(load(scenario, (), sets), tmp_path / "run", figure=False, page=True)
    told = tell_of(load(scenario, (), []))
    row = re.search(r"<tr>.*is it calm.*?</tr>", table(done.folder))
    assert row
    assert f">{verdict}, spectral radius {told[0].radius:.4g} over 7.81 ms<" in row[0]
    measured = done.summary.content["measures"].get("force_ripple")
    if measured is None:
        assert "m/s in the last tenth" in row[0]
    else:
        assert measured > 0.5
        assert "force ripple" in row[0]


def test_the_ripple_swings_at_the_mode_that_the_theory_names(tmp_path: Path) -> None:
    """Within an octave of it: where fingers let go in between, it swings slower."""
    scenario = load("two_users_box_centralized", (), ["duration=5 s", "expect={}"])
    done = run_scenario(scenario, tmp_path / "run", figure=False)
    with open_run(done.folder) as run:
        rows = foretold_rows(tell_of(scenario), run)
    frequencies = [float(re.search(r"at (\S+) Hz", cell)[1]) for cell in rows[1][1:]]
    assert frequencies[0] / 2 < frequencies[1] < frequencies[0]


def test_where_the_theory_refuses_its_sentence_stands() -> None:
    told = tell_of(load("thesis/rigid_contact", (), []))
    (note,) = foretold_notes(told)
    assert "the theory says nothing here" in note
    assert "a wall" in note


def test_both_worlds_are_told_and_what_is_left_out_is_said() -> None:
    told = tell_of(load("two_users_box_switched", (), []))
    assert [(loop.name, loop.is_stable) for loop in told] == [
        ("distributed", True),
        ("centralized", False),
    ]
    assert any("turned" in note for note in foretold_notes(told))
    assert any("Loss" in n for n in foretold_notes(tell_of(load("thesis/grasp_distributed_lossy"))))


@pytest.mark.parametrize("hertz", [3.0, 13.7, 40.0])
def test_the_frequency_of_a_swing_under_a_drift_is_found(hertz: float) -> None:
    time = np.arange(4096) / 1024
    found = _frequency(5.0 + 2.0 * time + np.sin(2 * np.pi * hertz * time), 1 / 1024)
    assert found == pytest.approx(hertz, abs=0.5)
