"""Hands in a scenario: who can be played, what nobody can break, and what a take is worth later."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.live.hands import pointers_of, users_of, with_hands
from cosim.live.mailbox import Mailbox
from cosim.live.pointer import Pointer
from cosim.reading import load
from cosim.record.digest import digest
from cosim.record.reader import open_run
from cosim.run import run_scenario
from tests.support.live.restless import Restless


def handed(name: str, folder: Path, *sets: str):
    """Users and scenario, with pointers in it."""
    emulated = load(name, (), sets)
    users = users_of(emulated)
    hands = folder / "hands.yaml"
    hands.write_text(json.dumps(with_hands(emulated, users)), encoding="utf-8")
    return users, load(name, (hands,), sets)


def test_both_users_of_the_box_can_be_played(tmp_path):
    users, scenario = handed("two_users_box", tmp_path)
    assert [user.station for user in users] == ["station_a", "station_b"]
    assert pointers_of(scenario) == ["pointer_station_a", "pointer_station_b"]
    assert scenario.expect == {}


def test_where_nobody_can_be_played_it_is_said():
    with pytest.raises(InputError, match=r"nobody can take part .* try 'cohaptic play"):
        users_of(load("single_axis_distributed"))
    with pytest.raises(InputError, match="is no take"):
        pointers_of(load("two_users_box"))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["two_users_box", "two_users_box_centralized"])
def test_no_motion_of_a_pointer_breaks_a_run(tmp_path, name, seed):
    users, scenario = handed(name, tmp_path, "duration=12 s")
    hands = {user.pointer: Restless(10 * seed + n) for n, user in enumerate(users)}
    finished = run_scenario(scenario, tmp_path / "run", figure=False, instances=hands)
    assert finished.error is None
    assert finished.summary.content["message"] == ""


def test_a_take_that_is_run_again_has_the_same_digest(tmp_path):
    users, scenario = handed("two_users_box", tmp_path, "duration=2 s")
    hands = {user.pointer: Restless(n) for n, user in enumerate(users)}
    take = tmp_path / "take"
    run_scenario(scenario, take, figure=False, instances=hands)
    again = tmp_path / "again"
    done = CliRunner().invoke(cli, ["play", "--again", str(take), "--out", str(again)])
    assert done.exit_code == 0, done.output
    other = tmp_path / "other"
    setting = ["--set", "channels.lan.round_trip_delay=2"]
    done = CliRunner().invoke(cli, ["play", "--again", str(take), "--out", str(other), *setting])
    assert done.exit_code == 0, done.output
    with open_run(take) as one, open_run(again) as two, open_run(other) as three:
        assert digest(one) == digest(two) != digest(three)
        for name in ("pointer_station_a.position_1[1]", "pointer_station_b.count"):
            assert (one[name][:] == three[name][:]).all()


def test_a_pointer_without_a_page_is_nobody(tmp_path):
    _, scenario = handed("two_users_box", tmp_path, "duration=0.5 s")
    finished = run_scenario(scenario, tmp_path / "run", figure=False)
    with open_run(finished.folder) as run:
        assert not run["pointer_station_a.valid"][:].any()


def test_an_emulated_user_without_a_hand_does_what_the_scenario_says(tmp_path):
    """Up to the first via point both are one motion; from there on, the hand waits."""
    _, scenario = handed("two_users_box", tmp_path, "duration=2 s")
    run_scenario(scenario, tmp_path / "run", figure=False)
    run_scenario(load("two_users_box", (), ("duration=2 s",)), tmp_path / "own", figure=False)
    with open_run(tmp_path / "run") as one, open_run(tmp_path / "own") as two:
        for name in ("vr_a.finger_1.normal_force", "vr_b.box_pose.x"):
            assert abs(one[name][:] - two[name][:]).max() < 1e-9


def test_samples_reach_the_loop_by_their_number_and_silence_is_nobody(monkeypatch):
    now = 100.0
    monkeypatch.setattr("cosim.live.pointer.time.monotonic", lambda: now)
    box = Mailbox.create()
    box.post(now, [9.0] * 4, present=True)
    pointer = Pointer(box)
    outputs = {v.name: __import__("numpy").zeros(v.shape or (1,)) for v in pointer.variables}
    from types import SimpleNamespace

    setup = SimpleNamespace(parameters={"centre_1": [0, 0], "centre_2": [1, 0], "reach": 0.1})
    pointer.initialise(setup, {}, outputs)
    pointer.read(0)
    assert not outputs["valid"][0], "what was said before the run does not count"
    box.post(now - 0.01, [0.05, 0.0, 3.0, 0.0], present=True)
    pointer.read(1)
    assert outputs["valid"][0]
    assert outputs["count"][0] == 2
    assert outputs["age"][0] == pytest.approx(0.01)
    assert outputs["position_1"].tolist() == [0.05, 0.0]
    assert outputs["position_2"].tolist() == pytest.approx([1.1, 0.0]), "no farther than it reaches"
    now += 0.3
    pointer.read(2)
    assert not outputs["valid"][0]
    box.remove()
