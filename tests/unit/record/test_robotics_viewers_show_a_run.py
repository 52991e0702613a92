"""MCAP has the scene where the record has it; layouts name signals that there are."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

from cosim.base.foxglove.entities import RATE
from cosim.base.foxglove.rows import ros_names
from cosim.base.foxglove.schema import NAME
from cosim.reading import load
from cosim.record.export.formats import export
from cosim.record.export.scene_updates import scene_updates
from cosim.record.reader import open_run
from cosim.run import run_scenario
from tests.support.live.foxglove import judge

LAYOUTS = Path(__file__).parents[3] / "docs" / "layouts"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("viewers") / "run"
    sets = ["duration=1.5 s", "start_time=10 s", "expect={}"]
    return run_scenario(load("two_users_box", (), sets), out, figure=False).folder


def by_id(message: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {entity["id"]: entity for entity in message["entities"]}


def test_the_scene_is_where_the_record_has_it(folder: Path) -> None:
    with open_run(folder) as run:
        updates = list(scene_updates(run, {*run.signals}, 0, run.ticks))
        assert len(updates) == 1.5 * RATE
        for tick, message in updates[::8]:
            found = by_id(message)
            assert {"box vr_a", "box vr_b", "finger vr_a 1", "finger vr_b 2"} <= {*found}
            (cube,) = found["box vr_b"]["cubes"]
            assert cube["pose"]["position"]["x"] == run["vr_b.box_pose.x"].values[tick]
            stamp = found["box vr_b"]["timestamp"]
            assert stamp["sec"] * 10**9 + stamp["nsec"] == (tick + 10240) * 10**9 // 1024
        last, message = updates[-1]
        (arrow,) = by_id(message)["finger vr_a 1"]["arrows"]
        force = [run[f"vr_a.finger_1.force[{axis}]"].values[last] for axis in (1, 2)]
        size = (force[0] ** 2 + force[1] ** 2) ** 0.5
        assert arrow["shaft_length"] == pytest.approx(0.02 * size)


def test_what_is_not_exported_is_not_drawn(folder: Path) -> None:
    with open_run(folder) as run:
        names = {f"vr_a.box_pose.{axis}" for axis in ("x", "y", "theta")}
        ((_, message), *_) = scene_updates(run, names, 100, 101)
        assert {*by_id(message)} == {"box vr_a"}
        assert list(scene_updates(run, {"lan.forward.age"}, 0, 10)) == []


def test_the_official_reader_gives_the_scene_back(folder: Path, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    with open_run(folder) as run:
        (path,) = export(run, "mcap", tmp_path / "out", patterns=["vr_?.*"], span=(0, 1000))
        expected = list(scene_updates(run, {*run.signals}, 0, 1000))
    with path.open("rb") as stream:
        found = list(reader.make_reader(stream).iter_messages(topics=["/scene"]))
    judge(json.loads(found[0][0].data))
    assert len(found) == len(expected)
    for (schema, channel, message), (tick, update) in zip(found, expected, strict=True):
        assert (schema.name, channel.message_encoding) == (NAME, "json")
        assert message.log_time == (tick + 10240) * 10**9 // 1024
        assert json.loads(message.data) == update


def paths_of(layout: Path) -> list[str]:
    """The topics and fields that a layout draws, as ``/topic/field``."""
    text = layout.read_text(encoding="utf-8")
    if layout.suffix == ".xml":
        return [curve.attrib["name"] for curve in ET.fromstring(text).iter("curve")]
    return [path.replace(".", "/") for path in re.findall(r'"value": "(/[^"]+)"', text)]


@pytest.mark.parametrize("name", ["foxglove.json", "plotjuggler.xml"])
def test_a_layout_names_what_the_default_scenario_records(folder: Path, name: str) -> None:
    with open_run(folder) as run:
        there = {
            f"/{group.name}/{field}"
            for group in run.groups.values()
            for field in ros_names(list(group.signals))
        }
    drawn = paths_of(LAYOUTS / name)
    assert len(drawn) >= 8
    assert {*drawn} <= there
