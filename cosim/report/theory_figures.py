"""Figures of the theory: stability regions and perceived admittances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.plot.style import COLOURS
from cosim.theory.numerics import Bool
from cosim.theory.stability.map import Axis
from cosim.theory.transparency.admittance import Response

_LINES = ("solid", "dashed", "dashdot", "dotted")


def _figure(columns: int) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(6.0 * columns, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, columns, squeeze=False)[0]


def _save(figure: Any, out: Path) -> None:
    known = figure.canvas.get_supported_filetypes()
    if out.suffix.lstrip(".").lower() not in known:
        raise InputError(f"{out}: name the figure .png, .svg or .pdf.")
    with writing(out):
        figure.savefig(out, dpi=150)


def draw_map(
    cells: Bool, plane: tuple[Axis, Axis], delays: Sequence[int], title: str, out: Path
) -> None:
    """Draw the borders of the stable regions of one plane, one colour a delay.

    Args:
        cells: shape (delays, y points, x points).
        plane: the horizontal and the vertical axis, N/m.
        delays: round trip of each map, in network samples.
        title: above the figure.
        out: the file; its suffix chooses the format.
    """
    x, y = plane
    figure, (axes,) = _figure(1)
    handles: list[Any] = []
    for number, (delay, stable) in enumerate(zip(delays, cells, strict=True)):
        colour = COLOURS[number % len(COLOURS)]
        line = _LINES[number % len(_LINES)]
        shown = stable.astype(np.float64)
        if stable.any():
            axes.contourf(x.values, y.values, shown, [0.5, 1.5], colors=[colour], alpha=0.10)
        if stable.any() and not stable.all():
            axes.contour(x.values, y.values, shown, [0.5], colors=[colour], linestyles=[line])
        empty = "" if stable.any() else " (nowhere stable)"
        (handle,) = axes.plot([], [], color=colour, linestyle=line, label=f"n = {delay}{empty}")
        handles.append(handle)
    axes.set_xlabel(f"{x.name} in N/m")
    axes.set_ylabel(f"{y.name} in N/m")
    axes.set_title(title, fontsize=9)
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _save(figure, out)


def draw_admittance(responses: Mapping[str, Response], unit: str, title: str, out: Path) -> None:
    """Draw magnitudes over frequency, one panel for each definition.

    Args:
        responses: by who feels them.
        unit: of the admittance.
        title: above the figure.
        out: the file; its suffix chooses the format.
    """
    figure, panels = _figure(2)
    for axes, definition in zip(panels, ("fundamental", "frame_lifted"), strict=True):
        for number, (felt, response) in enumerate(responses.items()):
            # Beyond half the network rate the lifted response only repeats itself.
            limit = np.inf if definition == "fundamental" else response.frame_limit
            shown = response.frequencies < limit
            axes.loglog(
                response.frequencies[shown],
                np.abs(getattr(response, definition))[shown],
                color="black" if felt == "ideal" else COLOURS[number % len(COLOURS)],
                linestyle=_LINES[number % len(_LINES)],
                label=felt,
            )
        name = "fundamental (T_c)" if definition == "fundamental" else "frame-lifted (6.1)"
        axes.set_title(name, fontsize=9)
        axes.set_xlabel("frequency in rad/s")
        axes.set_ylabel(f"magnitude in {unit}")
        axes.grid(visible=True, which="both", alpha=0.2)
        axes.legend()
    figure.suptitle(title, fontsize=10)
    _save(figure, out)
