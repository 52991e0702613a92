"""A parameter that is written with its unit is the same number in pictures, pages and walls."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from cosim.analysis.answers.device_of_wall import find_device
from cosim.analysis.answers.rendered_wall import WallOfDevice
from cosim.live.hands import users_of, with_hands
from cosim.live.knobs.found import knobs_of
from cosim.reading import load
from cosim.record import open_run
from cosim.report.path_panel import draw_path
from cosim.report.platform import platform_of
from cosim.run import run_scenario
from cosim.scenario.load import read

PLAIN = {"side": "0.08", "coupling_stiffness": "60.0", "compensation": "{x: -1.5, y: -1.5}"}
WRITTEN = {
    "side": "80 mm",
    "coupling_stiffness": "0.06 N/mm",
    "compensation": "{x: -1.5 N.s/m, y: -1500 g/s}",
}
WALL = {"point_x": "0.3", "point_y": "0.0", "normal_x": "-1", "normal_y": "0", "enabled": "true"}
WALL_WRITTEN = WALL | {"point_x": "300 mm", "point_y": "0 m"}


def sets(values: dict[str, str], wall: dict[str, str], length: str) -> list[str]:
    places = [f"components.vr_{who}.parameters" for who in "ab"]
    found = [f"{place}.{name}={value}" for place in places for name, value in values.items()]
    found += [f"{place}.wall_1.{name}={value}" for place in places for name, value in wall.items()]
    return [*found, f"components.finger_a1.parameters.proximal_length={length}", "duration=0.25 s"]


BOTH = (sets(PLAIN, WALL, "0.06"), sets(WRITTEN, WALL_WRITTEN, "60 mm"))


def test_knobs_and_hands_of_a_page() -> None:
    plain, written = (load("two_users_box", sets=each) for each in BOTH)
    assert [(k.key, k.start) for k in knobs_of(plain)] == [
        (k.key, pytest.approx(k.start)) for k in knobs_of(written)
    ]
    assert with_hands(written, users_of(written)) == with_hands(plain, users_of(plain))


def test_the_picture_of_the_way(tmp_path: Path) -> None:
    drawn: list[list[np.ndarray]] = []
    for number, each in enumerate(BOTH):
        folder = tmp_path / str(number)
        assert run_scenario(load("two_users_box", sets=each), folder).error is None
        with open_run(folder) as run, plt.rc_context({"legend.fontsize": 8}):
            figure, axis = plt.subplots()
            draw_path(axis, run, platform_of(run))
            drawn.append([np.asarray(line.get_xydata()) for line in axis.lines])
            plt.close(figure)
    assert len(drawn[0]) == len(drawn[1]) > 0
    for one, other in zip(*drawn, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_the_wall_of_a_device() -> None:
    found = []
    place = "components.finger_a1.parameters"
    for start, counts in (("[-0.065, 0.02]", "4000"), ("[-65 mm, 2 cm]", "4000")):
        more = [f"{place}.initial_tip_position={start}", f"{place}.encoder_counts={counts}"]
        written = read("two_users_box", (), more)
        with WallOfDevice(written, find_device(written.built(), "finger_a1", 0)) as wall:
            found.append(wall.facts)
    assert found[0] == found[1]
    assert found[0].count > 0.0
