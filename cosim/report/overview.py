"""The one figure of a run: where the box went, how it was held, and whether the copies agree.

Drawn after the loop from envelopes, so that a short spike is seen and a long run costs no more.
A scenario without a box gets its headline signals instead, one panel a unit.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cosim.record.reader import Run
from cosim.record.statistics import ColumnSummary
from cosim.report.panels import draw_contacts, draw_drift, draw_forces, draw_series
from cosim.report.path_panel import draw_path
from cosim.report.platform import platform_of
from cosim.report.summary import headlines

SIZE = (12.0, 7.2)
DPI = 120
MAX_PANELS = 5

STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "grid.color": "0.92",
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def draw_overview(
    run: Run, path: Path, summaries: Mapping[str, ColumnSummary], facts: str = ""
) -> None:
    """Draw a run into ``path`` (PNG); ``facts`` is a line under the title."""
    # pyplot would keep every figure and look for a display.
    matplotlib: Any = importlib.import_module("matplotlib")
    agg: Any = importlib.import_module("matplotlib.backends.backend_agg")
    with matplotlib.rc_context(STYLE):
        figure: Any = importlib.import_module("matplotlib.figure").Figure(
            figsize=SIZE, dpi=DPI, layout="constrained"
        )
        if run.ticks == 0:
            figure.text(0.5, 0.5, "nothing was recorded", ha="center", color="0.4")
        elif platform_of(run).copies:
            _draw_platform(figure, run, summaries)
        else:
            _draw_signals(figure, run, summaries)
        title = run.manifest.get("scenario", {}).get("title", "") or run.folder.name
        figure.suptitle(
            f"{title}\n{facts}" if facts else title, x=0.01, ha="left", fontsize=11, linespacing=1.5
        )
        agg.FigureCanvasAgg(figure).print_png(path)


def _draw_platform(figure: Any, run: Run, summaries: Mapping[str, ColumnSummary]) -> None:
    platform = platform_of(run)
    forces = [
        contact
        for contact in platform.contacts
        if contact.normal_force and summaries[contact.normal_force].statistics.maximum > 0
    ]
    touching = [
        contact for contact in platform.contacts if summaries[contact.state].statistics.maximum > 0
    ]
    heights = {
        "forces": 1.6 if forces else 0,
        "drift": 1.0,
        "contacts": 0.35 + 0.13 * len(touching),
    }
    if len(platform.copies) < 2:
        heights["drift"] = 0
    if not touching:
        heights["contacts"] = 0
    names = [name for name, height in heights.items() if height]
    mosaic = [["path", name] for name in names] or [["path"]]
    axes = figure.subplot_mosaic(
        mosaic,
        width_ratios=[1.0, 1.15] if names else [1.0],
        height_ratios=[heights[name] for name in names] or [1.0],
    )
    draw_path(axes["path"], run, platform)
    if "forces" in names:
        draw_forces(axes["forces"], run, forces, summaries)
    if "drift" in names:
        draw_drift(axes["drift"], run, platform)
    if "contacts" in names:
        draw_contacts(axes["contacts"], run, touching, summaries)
    for name in names:
        axes[name].set_xlim(*run.span)
        if name != names[-1]:
            axes[name].tick_params(labelbottom=False)
    if names:
        axes[names[-1]].set_xlabel("time (s)")


def _draw_signals(figure: Any, run: Run, summaries: Mapping[str, ColumnSummary]) -> None:
    units: dict[str, list[str]] = {}
    for name in headlines(run.signals):
        units.setdefault(run[name].unit, []).append(name)
    panels = list(units.items())[:MAX_PANELS]
    axes = figure.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, names) in zip(axes, panels, strict=False):
        draw_series(axis, run, {name: name for name in names}, summaries, unit)
    axes[-1].set_xlabel("time (s)")
    first, end = run.span
    axes[-1].set_xlim(first, max(end, first + 1e-9))
