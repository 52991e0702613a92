"""Torque beside what the model makes of it, the residual, and its correlations."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cosim.identification.five_bar import Array
from cosim.identification.results import Identified

SHOWN_SECONDS = 2.0
GAP_SECONDS = 0.02


def draw(found: Identified, out: Path) -> None:
    """Draw the fit into a file (png, svg or pdf).

    Raises:
        InputError: the file cannot be written.
    """
    from cosim.plot.figure import draw as draw_panels
    from cosim.plot.kinds import Line, Panel

    rows = found.rows[0]
    at = rows.chosen * rows.kernel.tick
    shown = at - at[0] <= SHOWN_SECONDS
    count = len(rows.chosen)
    # A line ends where rows are left out, and begins anew.
    ends = np.flatnonzero(np.diff(at[shown]) > GAP_SECONDS) + 1
    time: Array = np.insert(at[shown], ends, np.nan)
    panels: list[Panel] = []
    for joint in (0, 1):
        torque = np.insert(found.fit.torque[:count, joint][shown] * 1e3, ends, np.nan)
        model = np.insert(found.fit.predicted[:count, joint][shown] * 1e3, ends, np.nan)
        panels.append(
            Panel(
                "time (s)",
                f"joint {joint + 1} (mN.m)",
                (
                    Line("torque", time, torque),
                    Line("model", time, model),
                    Line("residual", time, torque - model),
                ),
                form="line",
            )
        )
    white = found.white
    bound = np.max(white.bound, axis=0)
    panels.append(
        Panel(
            "lag (s)",
            "correlation of the residual",
            (
                *(Line(f"joint {i + 1}", white.lags, white.correlations[i]) for i in (0, 1)),
                Line(
                    "95 % of chance",
                    np.r_[white.lags, np.nan, white.lags],
                    np.r_[bound, np.nan, -bound],
                ),
            ),
            form="line",
        )
    )
    names = ", ".join(each.name for each in found.runs)
    draw_panels(panels, out, title=f"What the model makes of {names}")
