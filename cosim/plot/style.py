"""How every figure looks: sizes of journals' columns, type, and colours for every reader's eyes."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.base.system.writing import writing

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F", "#000000")
"""Okabe and Ito's palette (2008), which colour-blind readers tell apart."""
LINES = ("solid", (0, (4, 1.5)), (0, (1, 1)), (0, (5, 1, 1, 1)))
"""Dash patterns, so that lines differ in print without colour as well."""

WIDTHS = {"one": 88.0, "two": 180.0}
"""Width (mm) of one and of two columns, of journals such as those of the IEEE and Elsevier."""
FORMATS = (".png", ".svg", ".pdf")
PAGE_FORMAT = ".html"
"""What signals are drawn as for a browser, besides."""
DPI = 300
MM_PER_INCH = 25.4

STYLE: Mapping[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.5,
    "lines.linewidth": 0.9,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "svg.hashsalt": "cohaptic",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}
"""Text stays text: searchable, and journals refuse Type 3 fonts (42 is TrueType)."""


def styled() -> AbstractContextManager[Any]:
    """The style for as long as the context is open."""
    matplotlib: Any = importlib.import_module("matplotlib")
    context: AbstractContextManager[Any] = matplotlib.rc_context(dict(STYLE))
    return context


def new_figure(width: float, height: float) -> Any:
    """An empty figure of a size in mm, bound to no display and kept by no list of figures."""
    figure: Any = importlib.import_module("matplotlib.figure").Figure(
        figsize=(width / MM_PER_INCH, height / MM_PER_INCH), dpi=DPI, layout="constrained"
    )
    importlib.import_module("matplotlib.backends.backend_agg").FigureCanvasAgg(figure)
    return figure


def save(figure: Any, out: Path) -> None:
    """Write a figure, the same bytes each time.

    Raises:
        InputError: the format is none of ``FORMATS``, or the file cannot be written.
    """
    suffix = out.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"{out}: a figure ends in {', '.join(FORMATS)}.")
    # The date of its making is the one thing that would differ.
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}[suffix]
    with writing(out):
        figure.savefig(out, metadata=undated)


def legend_above(axis: Any, columns: int = 4, **more: Any) -> None:
    """A legend between an axis and its title, where there is no data for it to cover.

    ``more`` are what a legend takes, such as its handles.
    """
    handles = more.get("handles") or axis.get_legend_handles_labels()[0]
    rows = -(-len(handles) // columns)
    size = importlib.import_module("matplotlib").rcParams["legend.fontsize"]
    axis.set_title(axis.get_title(loc="left"), loc="left", pad=5 + 1.45 * size * rows)
    look = {"handlelength": 1.4, "columnspacing": 1.2, "borderaxespad": 0.1, "labelspacing": 0.3}
    axis.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=min(columns, len(handles)), **look | more
    )


def thickness(number: int) -> float:
    """Width (points) of line ``number``: what lies over another leaves its edges to be seen."""
    return (2.2, 1.4, 0.9, 0.5)[number % 4]
