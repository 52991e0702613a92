"""Knobs of the page: what they turn, how far, and that a take with turned knobs runs again."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.cli import cli
from cosim.live.hands import users_of, with_hands
from cosim.live.knobs.found import knobs_of
from cosim.live.knobs.overlay import others_events, with_panels
from cosim.live.knobs.page_knob import knob_of, places
from cosim.live.knobs.panels import Panels
from cosim.live.panel import KNOBS, KnobPanel
from cosim.reading import load
from cosim.realtime.ring import Ring
from cosim.record.digest import digest
from cosim.record.reader import open_run
from cosim.run import run_scenario

SAMPLE = 8 / 1024


@pytest.fixture
def knobs():
    return knobs_of(load("two_users_box"))


@pytest.fixture
def panels(knobs):
    rings = {station: Ring.create(KNOBS, capacity=16) for station in places(knobs)}
    yield Panels(knobs, rings), rings
    for ring in rings.values():
        ring.remove()


def test_network_coupling_and_compensation_can_be_turned(knobs):
    assert [(knob.key, knob.start) for knob in knobs] == [
        ("lan.round_trip_delay", 1),
        ("lan.jitter", 0),
        ("lan.loss", 0),
        ("coupling_stiffness", 77.5),
        ("compensation", 0),
    ]
    central = [knob.key for knob in knobs_of(load("two_users_box_centralized"))]
    assert "remote_normal_stiffness" in central


def test_what_a_scenario_draws_itself_is_left_alone():
    lossy = knobs_of(load("thesis/grasp_distributed_lan_2006"))
    keys = {knob.key.partition(".")[2] for knob in lossy}
    assert not keys & {"jitter", "loss"}


@pytest.mark.parametrize(
    "delay", ["{forward: 2, backward: 0}", "{forward: 12 ticks, backward: 4 ticks}"]
)
def test_a_delay_that_is_shared_otherwise_than_a_round_trip_has_no_knob(delay):
    """Its knob would give each way another delay before anybody has turned it."""
    sets = ("channels.lan.round_trip_delay=~", f"channels.lan.delay={delay}")
    keys = [knob.key for knob in knobs_of(load("two_users_box", (), sets))]
    assert "lan.round_trip_delay" not in keys
    assert "lan.jitter" in keys


def test_a_knob_survives_its_way_to_the_server(knobs):
    assert [knob_of(json.loads(json.dumps(asdict(knob)))) for knob in knobs] == knobs


def test_a_round_trip_delay_is_shared_out_as_scenarios_do(panels):
    turned, rings = panels
    for samples, (forward, backward) in {0: (0, 0), 1: (1, 0), 2: (1, 1), 3: (2, 1)}.items():
        turned.hear({"lan.round_trip_delay": 4})
        assert turned.hear({"lan.round_trip_delay": samples})
        rows = {station: ring.newest() for station, ring in rings.items()}
        assert rows["station_a"][0] == forward * SAMPLE
        assert rows["station_b"][0] == backward * SAMPLE


@pytest.mark.parametrize(
    "wish",
    [
        None,
        [],
        {"lan.loss": 51},
        {"lan.loss": -1},
        {"lan.loss": "5"},
        {"lan.loss": True},
        {"lan.loss": float("nan")},
        {"nothing": 1},
        {"lan.loss": 0},
    ],
)
def test_a_wish_that_is_none_turns_nothing(panels, wish):
    turned, rings = panels
    assert not turned.hear(wish)
    assert all(ring.written == 0 for ring in rings.values())


def with_knobs(folder: Path, *sets: str, name: str = "two_users_box"):
    emulated = load(name)
    users, knobs = users_of(emulated), knobs_of(emulated)
    files = []
    for part, content in (
        ("hands", with_hands(emulated, users)),
        ("panels", with_panels(emulated, knobs)),
    ):
        files.append(folder / f"{part}.yaml")
        files[-1].write_text(json.dumps(content), encoding="utf-8")
    events = f"events={json.dumps(others_events(emulated, knobs))}"
    return knobs, load(name, files, (*sets, events))


def test_knobs_that_nobody_turns_change_nothing(tmp_path):
    _, scenario = with_knobs(tmp_path, "duration=2 s")
    run_scenario(scenario, tmp_path / "with", figure=False)
    run_scenario(load("two_users_box", (), ("duration=2 s",)), tmp_path / "own", figure=False)
    with open_run(tmp_path / "with") as one, open_run(tmp_path / "own") as two:
        for name in ("vr_a.box_pose.x", "vr_b.finger_1.normal_force", "lan.forward.age"):
            assert (one[name][:] == two[name][:]).all()


class Turned(KnobPanel):
    """Turned at every half second, as a page would."""

    def __init__(self, knobs, station) -> None:
        super().__init__()
        self._knobs, self._station = knobs, station

    def read(self, tick: int) -> None:
        delay = (tick // 512) % 4
        for index, (knob, wire) in enumerate(places(self._knobs)[self._station]):
            turned = {"lan.round_trip_delay": delay, "control": delay % 2}.get(knob.key, knob.start)
            self._values[index] = wire.value(10.0 if knob.key == "lan.loss" else turned)


@pytest.mark.parametrize("name", ["two_users_box", "two_users_box_switched"])
def test_a_take_with_turned_knobs_runs_again_to_the_same_digest(tmp_path, name):
    knobs, scenario = with_knobs(tmp_path, "duration=2 s", name=name)
    take, again = tmp_path / "take", tmp_path / "again"
    instances = {f"panel_{station}": Turned(knobs, station) for station in places(knobs)}
    run_scenario(scenario, take, figure=False, instances=instances)
    done = CliRunner().invoke(cli, ["play", "--again", str(take), "--out", str(again)])
    assert done.exit_code == 0, done.output
    with open_run(take) as one, open_run(again) as two:
        assert set(one["lan.forward.delay"][:]) == {0.0, SAMPLE, 2 * SAMPLE}
        if name == "two_users_box_switched":
            assert set(one["fade_a.share"][:]) > {0.0, 1.0}
        assert digest(one) == digest(two)
