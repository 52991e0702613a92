"""The picture of a sweep: a map with the theory's boundary, a curve, a histogram."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.plot.style import COLOURS, WIDTHS, new_figure, save, styled
from cosim.sweep.planning.axis import SweepAxis, number_of
from cosim.sweep.results.map_panel import Scale, label, panel_of
from cosim.sweep.results.table import columns_of
from cosim.sweep.sweep import SweepOutcome

PANELS = 4
"""Measures that are drawn."""
_BINS = 24
_NOT_MEASURES = {"number", "status", "ticks", "seconds", "checked", "message", "spectral_radius"}


def draw_sweep(outcome: SweepOutcome, file: Path) -> None:
    """Draw what fits the number of variables that are numbers, the seed apart.

    Raises:
        InputError: the file cannot be written.
    """
    axes = [axis for axis in outcome.plan.axes if axis.places != ("seed",) and _is_numeric(axis)]
    with styled():
        if len(axes) >= 2:
            figure = _map(outcome, axes[0], axes[1])
        elif axes:
            figure = _curves(outcome, axes[0])
        else:
            figure = _histograms(outcome)
        save(figure, file)


def _map(outcome: SweepOutcome, across: SweepAxis, up: SweepAxis) -> Any:
    figure = new_figure(WIDTHS["one"], 75.0)
    plot = figure.subplots()
    if across.span is None or up.span is None or _is_sampled(outcome, across, up):
        _scatter(plot, outcome, across, up)
    else:
        mesh = panel_of(outcome, across, up).draw(plot)
        figure.colorbar(mesh, label="share of good runs")
    return figure


def _scatter(plot: Any, outcome: SweepOutcome, across: SweepAxis, up: SweepAxis) -> None:
    places = [list(outcome.plan.axes).index(axis) for axis in (across, up)]
    for good, colour, marker, name in (
        (True, COLOURS[0], "o", "good"),
        (False, COLOURS[1], "x", "not good"),
    ):
        chosen = [each.point for each in outcome.results if each.is_good is good]
        x, y = ([number_of(point[place]) for point in chosen] for place in places)
        plot.plot(x, y, marker, color=colour, markersize=3, linestyle="none", label=name)
    plot.grid(visible=False)
    plot.legend()
    label(plot, Scale.of(across), Scale.of(up))


def _curves(outcome: SweepOutcome, axis: SweepAxis) -> Any:
    columns = columns_of(outcome)
    names = _measures(outcome)
    figure = new_figure(WIDTHS["one"], 30.0 + 32.0 * max(1, len(names)))
    plots = np.atleast_1d(figure.subplots(max(1, len(names)), sharex=True))
    x = np.array(columns[axis.name], dtype=float)
    good = np.array([result.is_good for result in outcome.results])
    for plot, name in zip(plots, names or ["good"], strict=True):
        y = good if name == "good" else np.array(columns[name], dtype=float)
        plot.plot(x[good], y[good], "o", markersize=2.5, color=COLOURS[0])
        plot.plot(x[~good], y[~good], "x", markersize=3, color=COLOURS[1])
        plot.set_title(name)
    plots[-1].set_xlabel(Scale.of(axis).label)
    plots[-1].set_xscale("log" if axis.is_log else "linear")
    return figure


def _histograms(outcome: SweepOutcome) -> Any:
    columns = columns_of(outcome)
    names = _measures(outcome)
    figure = new_figure(WIDTHS["one"], 30.0 + 32.0 * max(1, len(names)))
    plots = np.atleast_1d(figure.subplots(max(1, len(names))))
    for plot, name in zip(plots, names or ["status"], strict=True):
        if name == "status":
            plot.hist(columns["status"], color=COLOURS[0])
        else:
            values = np.array(columns[name], dtype=float)
            plot.hist(values[np.isfinite(values)], bins=_BINS, color=COLOURS[0])
        plot.set_title(name)
        plot.set_ylabel("runs")
    return figure


def _measures(outcome: SweepOutcome) -> list[str]:
    """The measures that are drawn: of those that differ, what was asked for first."""
    columns = columns_of(outcome)
    axes = {axis.name for axis in outcome.plan.axes}
    asked = [f"{target} {name}" for target, name in outcome.plan.job.readings]
    found: list[str] = []
    for name in dict.fromkeys([*asked, *columns]):
        values: Sequence[Any] = columns.get(name, [])
        numbers = {v for v in values if isinstance(v, float) and math.isfinite(v)}
        if name not in axes | _NOT_MEASURES and len(numbers) > 1 and not name.endswith(" high"):
            found.append(name)
    return found[:PANELS]


def _is_sampled(outcome: SweepOutcome, across: SweepAxis, up: SweepAxis) -> bool:
    """Whether the points lie anywhere, and not on the grid of the axes' values."""
    known = {list(outcome.plan.axes).index(axis): set(axis.values) for axis in (across, up)}
    points = outcome.plan.points
    return any(point[place] not in values for place, values in known.items() for point in points)


def _is_numeric(axis: SweepAxis) -> bool:
    return len(axis.values) > 1 and all(number_of(value) is not None for value in axis.values)
