"""An option that could act on nothing in this call is refused with what to write instead."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.cli.support.pace import Pace, pace_of
from cosim.reading import FORMS
from cosim.realtime.form import RealtimeForm
from cosim.scenario import load

MOCK = ("--with", "devices/mock")
STATION = ("station", "two_users_box", "--as", "station_a")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run", "single_user", "--policy", "stop"), "write --on-miss stop"),
        ((*STATION, "--policy", "count"), "write --on-miss count"),
        (("run", "single_user", "--on-miss", "stop"), "--on-miss without --realtime"),
        (("run", "single_user", "--cpu", "1"), "--cpu without --realtime"),
        (("run", "single_user", "--enable-output"), "single_user has no device"),
        (("run", "single_user", "--yes"), "single_user has no device"),
        (("run", "single_user", "--dead-man", "device"), "single_user has no device"),
        ((*STATION, "--enable-output"), "the station station_a has no device"),
        (("check", "--schema", "--set", "duration=1 s"), "--set beside --schema"),
        (("check", "single_user", "--schema"), "SCENARIO beside --schema"),
        (("device", "check", "mock://", "--yes"), "--yes without --enable-output"),
        (("device", "emulate", "haply", *MOCK), "--with without --scenario"),
        (("device", "emulate", "haply", "--component", "x"), "--component without --scenario"),
        (("device", "emulate", "haply", "--after", "0"), "--after without --fault"),
        (("device", "emulate", "haply", "--scenario", "two_users_box"), "--component finger_a1"),
        (("run", "two_users_box", *MOCK, "--yes"), "--yes without --enable-output"),
        (("run", "two_users_box", *MOCK, "--dead-man", "device"), "without --enable-output"),
    ],
)
def test_it_says_what_to_write(arguments, sentence, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=sentence):
        CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    assert not list(tmp_path.iterdir()), "nothing was begun"


PACES = {"on_miss": ("count", "stop"), "cpu": (0, 1)}


@pytest.mark.parametrize("key", sorted(RealtimeForm.model_fields))
def test_the_loop_is_paced_as_the_scenario_says(key, monkeypatch) -> None:
    """Every key of the form; one without values in ``PACES`` fails."""
    paces: list[Any] = []

    def run_scenario(*_: Any, execute: Any, **__: Any) -> None:
        paces.append({"cpu": execute.cpu, "on_miss": execute.pacer.policy})
        raise InputError("far enough")

    import_module("cosim.cli.support.run.child")  # or it would keep what stands here for a moment
    monkeypatch.setattr("cosim.run.run_scenario", run_scenario)
    for value in PACES[key]:
        over = ("--set", f"realtime.{key}={value}", "--realtime")
        with pytest.raises(InputError, match="far enough"):
            CliRunner().invoke(
                cli, ["run", "single_user", *over], catch_exceptions=False, standalone_mode=False
            )
    assert [pace[key] for pace in paces] == list(PACES[key])


def test_the_command_line_wins_over_realtime() -> None:
    scenario = load("single_user", (), ["realtime={on_miss: stop, cpu: 1}"], forms=FORMS)
    assert pace_of(scenario, on_miss=None, cpu=None) == Pace(on_miss="stop", cpu=1)
    assert pace_of(scenario, on_miss="count", cpu=0) == Pace(on_miss="count", cpu=0)
    assert pace_of(load("single_user"), on_miss=None, cpu=None) == Pace()
