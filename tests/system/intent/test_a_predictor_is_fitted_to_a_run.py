"""``cohaptic intent``: from a recorded run to a file that the next run is laid under."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.reading import load
from cosim.record import open_run

SHORT = ("run", "two_users_box", "--set", "duration=4.1 s", "--set", "expect=~", "--no-figure")


def invoke(*arguments: str) -> str:
    done = CliRunner().invoke(cli, list(arguments), standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return done.stdout


@pytest.mark.slow
def test_a_run_is_fitted_to_and_the_next_one_uses_it(tmp_path: Path) -> None:
    invoke(*SHORT, "--no-report", "--out", str(tmp_path / "run"))
    file = tmp_path / "mine.yaml"
    fingers = ("--finger", "vr_a.finger_1", "--finger", "vr_b.finger_2")
    said = json.loads(
        invoke("intent", str(tmp_path / "run"), *fingers, "--out", str(file), "--json")
    )
    errors = said["errors"]
    assert errors["intent"]["6"] < 0.7 * errors["hold"]["6"]
    with pytest.raises(InputError, match=r"no finger 'vr_a.finger_3'.*Did you mean"):
        invoke("intent", str(tmp_path / "run"), "--finger", "vr_a.finger_3")
    with pytest.raises(InputError, match="no multiple of --network-rate 100"):
        invoke("intent", str(tmp_path / "run"), "--network-rate", "100")
    parts = load("two_users_box", overlays=[str(file)]).components
    for name in ("vr_a", "vr_b"):
        assert parts[name].parameters["predictor"] == "intent"
        assert parts[name].parameters["intent.decay"] == pytest.approx(
            said["intent"]["decay"], rel=1e-3
        )
    delay = ("--set", "channels.lan.round_trip_delay=6", "--no-report")
    folder = tmp_path / "again"
    invoke(*SHORT, *delay, "--with", str(file), "--out", str(folder))
    with open_run(folder) as run:
        assert run["vr_a.box_pose.y"].values[-1] > 0.04, "it is carried"


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a run folder"):
        invoke("intent", str(tmp_path))
