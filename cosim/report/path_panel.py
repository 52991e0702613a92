"""The box's way through the plane: its copies, ghosts of the box along it, fingers and walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import CohapticError
from cosim.base.quantities.quantity import quantity
from cosim.plot.style import COLOURS, legend_above, thickness
from cosim.record.reader import SCENARIO_FILE, Run
from cosim.report.platform import RecordedPlatform

GHOSTS = 17
PATH_POINTS = 2000
DEFAULT_SIDE = 0.1
"""Side of the box (m) where the scenario does not say."""
MAX_WALLS = 4
FINGER_LABEL = {"textcoords": "offset points", "fontsize": 7.5, "zorder": 5}
TIME_LABEL = {"ha": "right", "va": "top", "fontsize": 7.5, "color": "0.25"}


def draw_path(axis: Any, run: Run, platform: RecordedPlatform) -> None:
    """Paths of the box's copies and the fingertips (m); ghosts darken with time."""
    paths = [
        np.stack([_sampled(run, name, PATH_POINTS) for name in pose])
        for pose in platform.poses.values()
    ]
    first = _parameters(run, platform.copies[0])
    side = float(quantity(first.get("side", DEFAULT_SIDE), "m"))
    moments = _moments(paths[0], side)
    for index, (copy, path) in enumerate(zip(platform.copies, paths, strict=True)):
        colour = COLOURS[index % len(COLOURS)]
        width = thickness(index)
        axis.plot(path[0], path[1], color=colour, linewidth=width, label=f"box of {copy}", zorder=3)
        _draw_ghosts(axis, [_outline(_at(path, m), side) for m in moments], colour, index)
        _draw_fingers(axis, run, copy, platform.tips[copy], colour)
    first_time, end_time = run.span
    for moment in moments:
        x, y = _outline(_at(paths[0], moment), side)[0]
        label = f"{first_time + moment * (end_time - first_time):.3g} s"
        axis.annotate(label, (x, y), (-3, -3), textcoords="offset points", **TIME_LABEL)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.08)
    _draw_walls(axis, first, paths[0][:2].mean(axis=1))
    axis.set_title("Box and fingers in the plane")
    axis.set_xlabel("x (m)")
    axis.set_ylabel("y (m)")
    legend_above(axis)


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
    outlines: Sequence[NDArray[np.float64]],
    colour: str,
    number: int,
) -> None:
    for order, outline in enumerate(outlines, 1):
        weight = order / len(outlines)
        if number == 0:
            axis.fill(*outline.T, color=colour, alpha=0.10 * weight, linewidth=0, zorder=1)
        axis.plot(
            *outline.T,
            color=colour,
            alpha=0.3 + 0.6 * weight,
            linewidth=thickness(number),
            zorder=2,
        )


def _draw_fingers(
    axis: Any, run: Run, copy: str, tips: Sequence[tuple[str, str]], colour: str
) -> None:
    """The ways of a user's fingertips; where they end stands whose they are."""
    for number, names in enumerate(tips, 1):
        x, y = (_sampled(run, name, PATH_POINTS) for name in names)
        if not x.any() and not y.any():
            continue  # no device is connected to it
        axis.plot(x, y, color=colour, linewidth=0.7, alpha=0.6, zorder=2)
        axis.plot(x[-1:], y[-1:], "o", color=colour, markersize=5, zorder=4)
        label = f"{copy} {number}" if len(tips) > 1 else copy
        axis.annotate(label, (x[-1], y[-1]), (6, -3), color=colour, **FINGER_LABEL)


def _draw_walls(axis: Any, parameters: Mapping[str, Any], centre: NDArray[np.float64]) -> None:
    """A wall has no end: only its point nearest to the box's way counts for what is shown."""
    for number in range(1, MAX_WALLS + 1):
        if not parameters.get(f"wall_{number}.enabled", False):
            continue
        point, normal = (
            np.array(
                [float(quantity(parameters.get(f"wall_{number}.{what}_{c}", 0.0), u)) for c in "xy"]
            )
            for what, u in (("point", "m"), ("normal", "1"))
        )
        length = float(np.hypot(*normal))
        if length == 0.0:
            continue
        along = np.array([-normal[1], normal[0]]) / length
        nearest = point + along * float(along @ (centre - point))
        axis.axline(nearest, nearest + SHORT * along, color="0.3", linewidth=2.0)


SHORT = 1e-3
"""Between the two points (m) that give a wall's line its direction."""


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
