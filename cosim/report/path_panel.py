"""The box's way through the plane: its copies, ghosts of the box along it, fingers and walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import CohapticError
from cosim.plot.style import COLOURS
from cosim.record.reader import SCENARIO_FILE, Run
from cosim.report.platform import RecordedPlatform

GHOSTS = 17
PATH_POINTS = 2000
DEFAULT_SIDE = 0.1
"""Side of the box (m) where the scenario does not say."""
MAX_WALLS = 4
TIME_LABEL = {"ha": "right", "va": "top", "fontsize": 7.5, "color": "0.25"}


def draw_path(axis: Any, run: Run, platform: RecordedPlatform) -> None:
    """Paths of the box's copies and the fingertips (m); ghosts darken with time."""
    paths = [
        np.stack([_sampled(run, name, PATH_POINTS) for name in pose])
        for pose in platform.poses.values()
    ]
    first = _parameters(run, platform.copies[0])
    side = float(first.get("side", DEFAULT_SIDE))
    moments = _moments(paths[0], side)
    for index, (copy, path) in enumerate(zip(platform.copies, paths, strict=True)):
        colour = COLOURS[index % len(COLOURS)]
        axis.plot(path[0], path[1], color=colour, linewidth=1.4, label=f"box of {copy}", zorder=3)
        _draw_ghosts(axis, path, side, moments, colour, is_first=index == 0)
        _draw_fingers(axis, run, platform.tips[copy], colour)
    duration = float(run.ticks / run.base_rate)
    for moment in moments:
        x, y = _outline(_at(paths[0], moment), side)[0]
        label = f"{moment * duration:.3g} s"
        axis.annotate(label, (x, y), (-3, -3), textcoords="offset points", **TIME_LABEL)
    _draw_walls(axis, first)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.08)
    axis.set_title("Box and fingers in the plane")
    axis.set_xlabel("x (m)")
    axis.set_ylabel("y (m)")
    axis.legend(loc="upper left")


def _moments(path: NDArray[np.float64], side: float) -> list[float]:
    """When ghosts are drawn, as shares of the run: at the start, and where the box has moved on."""
    chosen: list[float] = []
    poses: list[NDArray[np.float64]] = []
    for moment in np.linspace(0, 1, GHOSTS).tolist():
        here = _at(path, moment) * (1, 1, side)
        if all(np.abs(here - other).max() > side / 12 for other in poses):
            chosen.append(moment)
            poses.append(here)
    return chosen


def _at(path: NDArray[np.float64], moment: float) -> NDArray[np.float64]:
    return path[:, round(moment * (path.shape[1] - 1))]


def _outline(pose_: NDArray[np.float64], side: float) -> NDArray[np.float64]:
    """The corners of the box, the upper right one first and last, shape (5, 2)."""
    corners = 0.5 * side * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    cosine, sine = np.cos(pose_[2]), np.sin(pose_[2])
    return corners @ np.array([[cosine, sine], [-sine, cosine]]) + pose_[:2]


def _draw_ghosts(
    axis: Any,
    path: NDArray[np.float64],
    side: float,
    moments: Sequence[float],
    colour: str,
    *,
    is_first: bool,
) -> None:
    for order, moment in enumerate(moments):
        outline = _outline(_at(path, moment), side)
        weight = (order + 1) / len(moments)
        if is_first:
            axis.fill(*outline.T, color=colour, alpha=0.10 * weight, linewidth=0, zorder=1)
        style = "-" if is_first else "--"
        axis.plot(
            *outline.T, style, color=colour, alpha=0.3 + 0.6 * weight, linewidth=0.9, zorder=2
        )


def _draw_fingers(axis: Any, run: Run, tips: Sequence[tuple[str, str]], colour: str) -> None:
    for names in tips:
        x, y = (_sampled(run, name, PATH_POINTS) for name in names)
        axis.plot(x, y, color=colour, linewidth=0.7, alpha=0.6, zorder=2)
        axis.plot(x[-1:], y[-1:], "o", color=colour, markersize=5, zorder=4)


def _draw_walls(axis: Any, parameters: Mapping[str, Any]) -> None:
    for number in range(1, MAX_WALLS + 1):
        if not parameters.get(f"wall_{number}.enabled", False):
            continue
        point, normal = (
            [float(parameters.get(f"wall_{number}.{what}_{axis_}", default)) for axis_ in "xy"]
            for what, default in (("point", 0.0), ("normal", 0.0))
        )
        direction = (-normal[1], normal[0])
        axis.axline(
            point, (point[0] + direction[0], point[1] + direction[1]), color="0.3", linewidth=2.0
        )


def _sampled(run: Run, name: str, points: int) -> NDArray[np.float64]:
    """At most ``points`` evenly spaced rows, the last one among them."""
    signal = run[name]
    last = signal.group.rows - 1
    step = max(1, last // points)
    return signal[last % step :: step].astype(np.float64)


def _parameters(run: Run, component: str) -> Mapping[str, Any]:
    """A component's parameters in the scenario that ran; none where that cannot be read."""
    from cosim.scenario import load

    path = run.folder / SCENARIO_FILE
    if not path.exists():
        return {}
    try:
        return load(path).components[component].parameters
    except (CohapticError, KeyError):
        return {}
