"""Panels as a figure, of a journal's column width."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cosim.plot.kinds import Line, Panel
from cosim.plot.series import reduced
from cosim.plot.style import (
    COLOURS,
    LINES,
    PAGE_FORMAT,
    WIDTHS,
    new_figure,
    save,
    styled,
    thickness,
)

POINTS = 4000
"""Points of a line: two for each of the pixels that a figure is wide at most."""
PANEL_HEIGHT = 38.0
LEGEND_ROW = 3.6
EDGE = 12.0
LABELS, CHARACTER, HANDLE = 16.0, 1.45, 9.0
"""Widths (mm) of what stands left of the axes, of a letter, and of a legend's sample of a line."""
POINTS_PER_MM = 72 / 25.4
SHARE = 0.62
"""Height of a square or logarithmic panel, as a share of its width."""


def draw(panels: Sequence[Panel], out: Path, *, width: str = "two", title: str = "") -> None:
    """Draw panels below one another into a file (png, svg or pdf; or html, which has no width).

    Raises:
        InputError: the file cannot be written, or its ending is no format.
    """
    if out.suffix.lower() == PAGE_FORMAT:
        from cosim.plot.page.document import draw_page

        draw_page(panels, out, title)
        return
    wide = WIDTHS[width]
    heights = [_height(panel, wide) for panel in panels]
    with styled():
        figure = new_figure(wide, sum(heights) + EDGE + (6 if title else 0))
        axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
        for number, (axis, panel) in enumerate(zip(axes, panels, strict=True), 1):
            alone = number == len(panels) or panels[number].x != panel.x
            _draw_panel(axis, panel, wide, is_last=alone or panel.form != "steps")
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=8.5, fontweight="bold")
        save(figure, out)


def _height(panel: Panel, wide: float) -> float:
    body = SHARE * wide if panel.is_square else PANEL_HEIGHT
    return body + LEGEND_ROW * _rows(panel, wide) + (LEGEND_ROW if panel.title else 0.0)


def _rows(panel: Panel, wide: float) -> int:
    return -(-len(panel.lines) // _columns(panel, wide)) if _has_legend(panel) else 0


def _columns(panel: Panel, wide: float) -> int:
    """Columns of a legend that fit beside each other."""
    longest = max(len(line.label) for line in panel.lines)
    room = (wide - LABELS) / (CHARACTER * longest + HANDLE)
    return max(1, min(len(panel.lines), int(room)))


def _has_legend(panel: Panel) -> bool:
    """A line without a name is named by the panel."""
    return any(line.label for line in panel.lines)


def _draw_panel(axis: Any, panel: Panel, wide: float, *, is_last: bool) -> None:
    for number, line in enumerate(panel.lines):
        look = {
            "color": COLOURS[number % len(COLOURS)],
            "linestyle": LINES[number // len(COLOURS) % len(LINES)],
            "label": line.label,
            "linewidth": thickness(number) if len(panel.lines) > 1 else None,
        }
        _draw_line(axis, panel, line, look)
    if is_last:
        axis.set_xlabel(panel.x)
    else:
        axis.tick_params(labelbottom=False)
    axis.set_ylabel(panel.y)
    if panel.items:
        axis.set_yticks([*panel.items], [*panel.items.values()])
    if panel.is_logarithmic:
        axis.set_xscale("log")
        axis.set_yscale("log")
    elif panel.is_square:
        axis.set_aspect("equal", adjustable="datalim")
    elif panel.form == "steps":
        axis.margins(x=0)
    if panel.form == "bars":
        axis.set_ylim(bottom=0)
    rows = _rows(panel, wide)
    if panel.title:
        # Above the legend, whose rows it has to clear.
        axis.set_title(panel.title, pad=3 + rows * LEGEND_ROW * POINTS_PER_MM)
    if rows:
        # Above the axes: nothing is covered there.
        axis.legend(
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=_columns(panel, wide),
            borderaxespad=0.1,
            columnspacing=1.2,
        )


def _draw_line(axis: Any, panel: Panel, line: Line, look: dict[str, Any]) -> None:
    if panel.form == "bars":
        axis.stairs(line.y, line.x, **look)
    elif panel.form == "steps":
        axis.plot(*reduced(line.x, line.y, POINTS), drawstyle="steps-post", **look)
    else:
        axis.plot(line.x, line.y, **look)
