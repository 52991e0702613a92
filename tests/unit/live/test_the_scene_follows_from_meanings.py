"""What is drawn is found by what signals mean, whatever they are called."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from cosim import scene as scene_module
from cosim.base.drawn import signals_of
from cosim.master.run.simulation import assemble
from cosim.reading import load
from cosim.scene import describe_scene
from tests.support.live.renamed import BOX, write_scenario


def described(name: str, *sets: str) -> dict:
    simulation = assemble(load(name, (), sets))
    return describe_scene(simulation.assembly, simulation.groups)


@pytest.fixture(scope="module")
def box() -> dict:
    return described("two_users_box")


def test_two_copies_four_fingers_and_their_devices_are_found(box: dict) -> None:
    assert [copy["name"] for copy in box["boxes"]] == ["vr_a", "vr_b"]
    assert {copy["side"] for copy in box["boxes"]} == {0.1}
    assert {copy["friction"] for copy in box["boxes"]} == {0.6}
    assert [(f["station"], f["finger"]) for f in box["fingers"]] == [
        ("station_a", 1),
        ("station_a", 2),
        ("station_b", 1),
        ("station_b", 2),
    ]
    for finger in box["fingers"]:
        assert (finger["device"]["proximal"], finger["device"]["distance"]) == (0.1, 0.085)
        assert finger["limit"] == 2.5
    assert box["fingers"][3]["device"]["base"] == pytest.approx([0.1125, 0.21, 3.14159], abs=1e-4)
    assert [channel["name"] for channel in box["channels"]] == ["lan.forward", "lan.backward"]


@pytest.mark.parametrize("name", ["four_users", "wall_push_centralized_remote"])
def test_a_finger_that_nothing_drives_is_not_there(name: str) -> None:
    fingers = described(f"thesis/{name}", "record=['*']")["fingers"]
    assert {finger["finger"] for finger in fingers} == {1}
    assert len({finger["station"] for finger in fingers}) == len(fingers) >= 2


def test_every_signal_of_a_scene_is_recorded(box: dict) -> None:
    simulation = assemble(load("two_users_box"))
    recorded = {column.name for group in simulation.groups for column in group.columns}
    named = signals_of(box)
    assert len(named) == len(set(named)) > 40
    assert set(named) <= recorded


def test_walls_that_are_enabled_are_drawn_once() -> None:
    assert described("thesis/wall_push_distributed")["walls"] == [[0.0, 0.05, 0.0, -1.0]]
    assert described("two_users_box")["walls"] == []


def test_bodies_on_one_axis_are_drawn_where_there_is_no_box() -> None:
    names = [body["name"] for body in described("single_axis_distributed")["bodies"]]
    assert names == ["hand_1", "object_1", "hand_2", "object_2"]


def test_a_model_of_somebody_else_is_drawn_by_its_meanings(tmp_path: Path) -> None:
    drawn = described(str(write_scenario(tmp_path)))
    assert drawn["boxes"][0]["pose"] == [f"mine.{name}" for name in BOX]
    assert drawn["boxes"][0]["side"] == 0.3


def test_no_name_of_a_variable_stands_in_the_code() -> None:
    text = Path(scene_module.__file__).read_text("utf-8")
    constants = {
        node.value
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    assert not constants & {"box_pose", "finger_1", "joint_angle", "contact_state", "base_x"}
