"""A figure as one page for a browser: it opens from a file, is zoomed, and loads nothing."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.system.writing import writing
from cosim.plot.kinds import Line, Panel
from cosim.plot.page.bundle import bundle
from cosim.plot.series import reduced, reduced_way

HERE = Path(__file__).parent
LIVE = HERE.parents[1] / "live" / "page"
"""The live page, whose colours and plots these are."""
MODULES = (LIVE / "vendor" / "uPlot.js", LIVE / "theme.js", HERE / "plot.js")
STYLES = (LIVE / "vendor" / "uPlot.css", LIVE / "style.css", HERE / "plot.css")
POINTS = 65536
"""Of a line; a longer one keeps the least and the greatest of every few."""


def draw_page(panels: Sequence[Panel], out: Path, title: str = "") -> None:
    """Write panels below one another as a page.

    Raises:
        InputError: the file cannot be written.
    """
    jinja: Any = import_module("jinja2")
    markup: Any = import_module("markupsafe").Markup
    environment = jinja.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string((HERE / "plot.html.j2").read_text(encoding="utf-8"))
    data = json.dumps([_panel(panel) for panel in panels], allow_nan=False, separators=(",", ":"))
    page = template.render(
        title=title or " · ".join(dict.fromkeys(map(_name, panels))),
        # Nothing in data may close the element that it stands in.
        data=markup(data.replace("<", "\\u003c")),
        script=markup(bundle(MODULES).replace("</script", "<\\/script")),
        style=markup("\n".join(file.read_text(encoding="utf-8") for file in STYLES)),
    )
    with writing(out):
        out.write_text(page, encoding="utf-8")


def _name(panel: Panel) -> str:
    """What a panel shows, for a page that was given no title."""
    labels = [line.label for line in panel.lines if line.label]
    more = ", …" if len(labels) > NAMED else ""
    return panel.title or ", ".join(labels[:NAMED]) + more or f"{panel.y} over {panel.x}"


NAMED = 3
"""Signals that a page's title names."""


def _panel(panel: Panel) -> dict[str, Any]:
    return {
        "x": panel.x,
        "y": panel.y,
        "form": panel.form,
        "logarithmic": panel.is_logarithmic,
        "square": panel.is_square,
        # Where x goes back and forth, a line is drawn in the order of its points.
        "plane": panel.form == "line" and not panel.is_logarithmic,
        "items": {str(value): name for value, name in panel.items.items()},
        "title": panel.title,
        "lines": [_line(panel, line) for line in panel.lines],
    }


def _line(panel: Panel, line: Line) -> dict[str, Any]:
    x, y = line.x, line.y
    if panel.form == "steps" or panel.is_logarithmic:
        x, y = reduced(x, y, POINTS)
    elif panel.form == "line":
        x, y = reduced_way(x, y, POINTS)
    elif panel.form == "bars":
        y = np.append(y, y[-1])  # the last bar ends at the last edge
    return {"label": line.label, "x": encode(x), "y": encode(y)}


def encode(values: NDArray[np.float64]) -> str:
    """Numbers bit for bit: their bytes apart, as neighbours' are alike, deflated, as text."""
    planes = values.astype("<f8").view(np.uint8).reshape(-1, 8).T
    deflate = zlib.compressobj(6, zlib.DEFLATED, -zlib.MAX_WBITS)
    return base64.b64encode(deflate.compress(planes.tobytes()) + deflate.flush()).decode("ascii")


def decode(text: str) -> NDArray[np.float64]:
    """The numbers again, shape (points,): what the page shows."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text), -zlib.MAX_WBITS), np.uint8)
    return np.ascontiguousarray(planes.reshape(8, -1).T).view("<f8")[:, 0]
