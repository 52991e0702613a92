"""The figures of chapter 8 from the records of the runs."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.plot.style import COLOURS, legend_above
from cosim.record.reader import Run, open_run
from cosim.report.overview import STYLE
from cosim.thesis.experiments import Ran

Floats = NDArray[np.float64]

SIZE = (9.0, 3.4)
DPI = 110
STRIDE = 4
"""Every fourth sample is drawn; 256 a second are enough for the eye."""


def draw_figures(runs: Mapping[str, Ran], out: Path) -> dict[str, str]:
    """Draw every figure whose runs are there: name -> file name in ``out``."""
    importlib.import_module("matplotlib").use("agg")
    pyplot: Any = importlib.import_module("matplotlib.pyplot")
    drawn: dict[str, str] = {}
    with pyplot.rc_context(STYLE):
        for name, (needed, draw) in FIGURES.items():
            if any(runs[one].failure or not runs[one].summary for one in needed):
                continue
            figure: Any = pyplot.figure(figsize=SIZE, dpi=DPI, layout="constrained")
            opened = {one: open_run(runs[one].folder) for one in needed}
            try:
                draw(figure, opened)
            finally:
                for run in opened.values():
                    run.close()
            drawn[name] = f"figure_{name}.png"
            figure.savefig(out / drawn[name])
            pyplot.close(figure)
    return drawn


def _series(run: Run, *names: str, sign: float = 1.0) -> tuple[Floats, Floats]:
    """Time (s) and the sum of the signals with alternating signs (first plus, others minus)."""
    first = run[names[0]]
    values = np.asarray(first.values, np.float64)[::STRIDE].copy()
    for other in names[1:]:
        values -= np.asarray(run[other].values, np.float64)[::STRIDE]
    return first.group.time[::STRIDE], sign * values


def _grasp(figure: Any, runs: Mapping[str, Run]) -> None:
    force, path = figure.subplots(1, 2, width_ratios=(2, 1))
    shown = (
        ("grasp_distributed", "distributed", "vr_b.finger_1.normal_force", "vr_b"),
        (
            "grasp_centralized",
            "centralized, remote",
            "server.client_contact_1.finger_1_normal_force",
            "server",
        ),
    )
    for colour, (name, label, signal, copy) in zip(COLOURS[1::-1], reversed(shown), strict=True):
        run = runs[name]
        time, values = _series(run, signal)
        force.plot(time, values, color=colour, linewidth=0.8, label=label)
        x = 1e3 * _series(run, f"{copy}.box_pose.x")[1]
        y = 1e3 * _series(run, f"{copy}.box_pose.y")[1]
        path.plot(x, y, color=colour, linewidth=1.0)
    force.set(title="(a) Normal force of user b's left finger", xlabel="time (s)", ylabel="N")
    legend_above(force, 2)
    path.set(title="(b) Path of the box", xlabel="x (mm)", ylabel="y (mm)", aspect="equal")


def _free_motion(figure: Any, runs: Mapping[str, Run]) -> None:
    axis = figure.subplots()
    copies = ("vr_a.finger_1.normal_force", "vr_b.finger_1.normal_force")
    shown = (
        ("free_motion", "distributed", copies),
        ("free_motion_printed", "distributed, -0.88 N·s/m", copies),
        ("free_motion_compensated", "distributed, compensated at n = 1", copies),
        (
            "free_motion_local",
            "centralized, local",
            ("server.finger_1.normal_force", "server.client_contact_1.finger_1_normal_force"),
        ),
    )
    for colour, (name, label, signals) in zip(COLOURS, shown, strict=False):
        time, values = _series(runs[name], *signals)
        axis.plot(time, values, color=colour, linewidth=1.0, label=label)
    ideal = np.linspace(4.0, 14.0, 1000)
    axis.plot(
        ideal, -0.08 * np.sin(2 * ideal), "k--", linewidth=1.0, label="inertial force (ideal)"
    )
    axis.set(
        title="Net force of both fingers on the box",
        xlabel="time (s)",
        ylabel="N",
        xlim=(4.5, 14.0),
    )
    legend_above(axis, 5)


def _wall_push(figure: Any, runs: Mapping[str, Run]) -> None:
    axis = figure.subplots()
    shown = (
        ("wall_push_distributed", "distributed", "finger_a"),
        ("wall_push_centralized_local", "centralized, local", "finger_a"),
        ("wall_push_centralized_remote", "centralized, remote", "finger_b"),
    )
    for number, (name, label, finger) in enumerate(shown):
        time, values = _series(runs[name], f"{finger}.tip_position[2]")
        style = "--" if number == 1 else "-"
        axis.plot(time, 1e3 * (values - values[0]), style, color=COLOURS[number], label=label)
    axis.set(title="Finger pushing the box to the wall", xlabel="time (s)", ylabel="mm")
    legend_above(axis, 3)


def _moment_cancellation(figure: Any, runs: Mapping[str, Run]) -> None:
    position, force = figure.subplots(1, 2)
    shown = (("rigid_contact", "without impulses"), ("rigid_contact_cancelled", "with impulses"))
    for colour, (name, label) in zip(COLOURS, shown, strict=False):
        time, tip = _series(runs[name], "finger_a.tip_position[2]")
        position.plot(time, 1e3 * (tip + 0.05), color=colour, label=label)
        time, normal = _series(runs[name], "vr_a.finger_1.normal_force")
        force.plot(time, normal, color=colour, label=label)
    for axis in (position, force):
        axis.set(xlim=(0.0, 0.4), xlabel="time (s)")
    position.set(title="Finger past the surface", ylabel="mm")
    force.set(title="Contact force", ylabel="N")
    legend_above(position, 2)


Draw = Callable[[Any, Mapping[str, Run]], None]

FIGURES: dict[str, tuple[tuple[str, ...], Draw]] = {
    "8.1": (("grasp_distributed", "grasp_centralized"), _grasp),
    "8.3": (
        ("free_motion", "free_motion_printed", "free_motion_compensated", "free_motion_local"),
        _free_motion,
    ),
    "8.4": (
        ("wall_push_distributed", "wall_push_centralized_local", "wall_push_centralized_remote"),
        _wall_push,
    ),
    "7.4": (("rigid_contact", "rigid_contact_cancelled"), _moment_cancellation),
}
"""Name -> the runs it needs and the function that draws it."""
