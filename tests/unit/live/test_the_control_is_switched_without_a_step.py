"""A crossfade of two worlds: bounded, between both, and no part of a world that has no share."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.component import Setup
from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.cli.support.play_theory import theory_of
from cosim.live.crossfade import Crossfade
from cosim.live.knobs.found import knobs_of
from cosim.live.knobs.overlay import others_events
from cosim.live.knobs.page_knob import places
from cosim.live.knobs.panels import Panels
from cosim.live.panel import KNOBS
from cosim.master.run.simulation import assemble
from cosim.reading import load
from cosim.realtime.ring import Ring
from cosim.scene import describe_scene

SWITCHED = "two_users_box_switched"
TORQUES = st.lists(st.floats(-0.5, 0.5), min_size=8, max_size=8)


def crossfade(seconds=0.5, position=0.0, rate=1024):
    fade = Crossfade()
    inputs = {f"{w}_{n}": np.zeros(2) for w in ("first", "second") for n in (1, 2)}
    inputs["position"] = np.array([position])
    outputs = {"torque_1": np.zeros(2), "torque_2": np.zeros(2), "share": np.zeros(1)}
    given_parameters = {"fade_time": seconds, "position": position}
    told = Setup(name="f", parameters=given_parameters, tick=(1, rate), period=1, seed=0)
    fade.initialise(told, inputs, outputs)
    return fade, inputs, outputs


@settings(max_examples=20)
@given(st.lists(st.tuples(TORQUES, st.sampled_from([0.0, 0.3, 1.0])), min_size=1, max_size=40))
def test_what_is_passed_on_lies_between_both_and_the_share_is_bounded(steps):
    fade, inputs, outputs = crossfade(0.02)
    before = 0.0
    for tick, (torques, position) in enumerate(steps):
        for place, name in enumerate(("first_1", "first_2", "second_1", "second_2")):
            inputs[name][:] = torques[2 * place : 2 * place + 2]
        inputs["position"][0] = position
        fade.evaluate(tick)
        for n in (1, 2):
            pair = inputs[f"first_{n}"], inputs[f"second_{n}"]
            assert (outputs[f"torque_{n}"] >= np.minimum(*pair) - 1e-15).all()
            assert (outputs[f"torque_{n}"] <= np.maximum(*pair) + 1e-15).all()
        share = outputs["share"][0]
        assert 0.0 <= share <= 1.0
        assert abs(share - before) <= 1 / (0.02 * 1024) + 1e-12
        before = share
        fade.step(tick)


@pytest.mark.parametrize("position", [0.0, 1.0])
def test_a_world_without_a_share_has_no_part_even_if_it_is_no_number(position):
    fade, inputs, outputs = crossfade(position=position)
    inputs["second_1" if position == 0.0 else "first_1"][:] = np.nan
    fade.evaluate(0)
    assert (outputs["torque_1"] == 0.0).all()


def test_the_fade_takes_its_time_and_goes_on_from_a_snapshot():
    fade, inputs, outputs = crossfade(0.5)
    inputs["position"][0] = 1.0
    for tick in range(256):
        fade.step(tick)
    saved = json.loads(json.dumps(fade.save()))
    other, more, seen = crossfade(0.5)
    more["position"][0] = 1.0
    other.load(saved)
    for each in (fade, other):
        for tick in range(256, 511):
            each.step(tick)
        each.evaluate(511)
    assert outputs["share"][0] == seen["share"][0] == pytest.approx(511 / 512)


def test_a_fade_without_time_is_refused():
    with pytest.raises(InputError, match=r"f: fade_time is 0 s"):
        crossfade(0.0)


def test_until_it_is_switched_a_run_is_that_of_the_distributed_scenario():
    runs = []
    for name, sets in ((SWITCHED, ("events=~",)), ("two_users_box", ())):
        sink = MemorySink()
        with assemble(load(name, (), ("duration=1.5 s", *sets))) as simulation:
            simulation.run(sink)
        runs.append(sink)
    for signal in ("vr_a.box_pose.x", "vr_b.finger_1.normal_force", "finger_b2.tip_position[1]"):
        one, two = (sink.signal(signal) for sink in runs)
        assert np.array_equal(one, two)


def test_a_scene_says_which_world_each_thing_is_of():
    simulation = assemble(load(SWITCHED))
    scene = describe_scene(simulation.assembly, simulation.groups)
    assert {box["name"]: (box["share"], box["world"], box["side"]) for box in scene["boxes"]} == {
        "vr_a": ("fade_a.share", 0, 0.1),
        "vr_b": ("fade_b.share", 0, 0.1),
        "server": ("fade_a.share", 1, 0.1),
        "client": ("fade_b.share", 1, 0.1),
    }
    assert [finger["world"] for finger in scene["fingers"]].count(1) == 4
    simulation = assemble(load("two_users_box"))
    scene = describe_scene(simulation.assembly, simulation.groups)
    assert all("share" not in each for each in (*scene["boxes"], *scene["fingers"]))


def test_the_theory_of_each_architecture_is_that_of_its_own_scenario():
    scenario = load(SWITCHED)
    found = theory_of(scenario, knobs_of(scenario))
    names = {"distributed": "two_users_box", "centralized": "two_users_box_centralized"}
    assert [world["name"] for world in found["worlds"]] == list(names)
    assert found["switch"] == knobs_of(scenario)[0].key
    for world in found["worlds"]:
        own = load(names[world["name"]])
        alone = theory_of(own, knobs_of(own))["worlds"][0]
        assert world == alone
        period = 8 / 1024
        for radius, modes in zip(world["radii"], world["modes"], strict=True):
            assert modes[0][0] ** period == pytest.approx(radius, rel=1e-4)


def test_a_page_switches_both_stations_and_nothing_between():
    scenario = load(SWITCHED)
    knobs = knobs_of(scenario)
    switch = knobs[0]
    assert switch.choices == ("distributed", "centralized")
    rings = {station: Ring.create(KNOBS, capacity=16) for station in places(knobs)}
    try:
        panels = Panels(knobs, rings)
        assert not panels.hear({switch.key: 0.5})
        assert panels.hear({switch.key: 1})
        assert {ring.newest()[0] for ring in rings.values()} == {1.0}
    finally:
        for ring in rings.values():
            ring.remove()


def test_people_take_over_what_the_scenario_would_have_turned():
    turned = "events=[{at: 1 s, set: {fade_a.position: 1, vr_a.local_normal_damping: 4}}]"
    scenario = load(SWITCHED, (), (turned,))
    left = others_events(scenario, knobs_of(scenario))
    assert left == [{"at": "1024 ticks", "set": {"vr_a.local_normal_damping": 4}}]
    again = load(SWITCHED, (), (f"events={json.dumps(left)}",))
    assert [(e.tick, str(e.target), e.value) for e in again.events] == [
        (1024, "vr_a.local_normal_damping", 4)
    ]
    assert others_events(load(SWITCHED), knobs_of(scenario)) == []
