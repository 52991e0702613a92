"""In a run's overview no legend lies over data, every own finger is named, and the box fills it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from cosim.reading import load
from cosim.run import run_scenario

RUNS = {
    "two_users_box": (["duration=2 s"], 4),
    "scenarios/thesis/four_users": (["duration=2 s"], 4),
    "scenarios/thesis/wall_push_distributed": ([], 2),
    "single_axis_distributed": ([], 0),
}


@pytest.fixture(params=RUNS, scope="module")
def drawn(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Any]:
    """The name of a scenario, and the figure of its run as it was written."""
    kept: list[Any] = []
    with pytest.MonkeyPatch.context() as patch:
        write = FigureCanvasAgg.print_png

        def print_png(canvas: Any, *arguments: Any, **named: Any) -> None:
            write(canvas, *arguments, **named)
            kept.append(canvas.figure)

        patch.setattr(FigureCanvasAgg, "print_png", print_png)
        sets, _ = RUNS[request.param]
        folder: Path = tmp_path_factory.mktemp("drawn") / "run"
        scenario = load(request.param, (), [*sets, "expect={}"] if sets else [])
        run_scenario(scenario, folder)
    return request.param, kept[-1]


def test_no_legend_lies_over_data(drawn: tuple[str, Any]) -> None:
    _, figure = drawn
    legends = [axis for axis in figure.axes if axis.get_legend() is not None]
    assert legends
    for axis in legends:
        box, data = axis.get_legend().get_window_extent(), axis.get_window_extent()
        assert box.y0 >= data.y1 - 1
        assert box.x1 <= figure.bbox.x1


def test_a_legend_is_short(drawn: tuple[str, Any]) -> None:
    _, figure = drawn
    for axis in figure.axes:
        if axis.get_legend() is not None:
            assert len(axis.get_legend().get_texts()) <= 8


def test_every_own_finger_is_named(drawn: tuple[str, Any]) -> None:
    name, figure = drawn
    texts = {text.get_text() for axis in figure.axes for text in axis.texts}
    assert len({text for text in texts if text.startswith("vr_")}) == RUNS[name][1]


def test_the_box_is_not_lost_in_the_plane(drawn: tuple[str, Any]) -> None:
    """The view is at most three times what moved, whatever walls there are."""
    name, figure = drawn
    if not RUNS[name][1]:
        return
    axis = figure.axes[0]
    lines = [line.get_xydata() for line in axis.lines if len(line.get_xydata()) > 2]
    extent = np.ptp(np.concatenate(lines), axis=0).max()
    assert max(axis.viewLim.width, axis.viewLim.height) <= 3 * extent
