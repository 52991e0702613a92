"""Panels over time: envelopes of signals, distance between copies, bands of contact states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.plot.style import COLOURS, legend_above, thickness
from cosim.record.reader import Run
from cosim.record.signals import SignalGroup
from cosim.record.statistics import ColumnStatistics, ColumnSummary
from cosim.report.platform import Contact, RecordedPlatform
from cosim.report.target import Target, blocks

CONTACT_STATES = (
    ("free", "#E8E8E8"),
    ("moment cancellation", "#F0E442"),
    ("pre-slide", "#56B4E9"),
    ("slide", "#D55E00"),
)


def bin_times(run: Run, group: SignalGroup, summary: ColumnSummary) -> NDArray[np.float64]:
    """Middle of each bin of an envelope (s), shape (bins,)."""
    bins = np.arange(summary.lows.size)
    rows = (bins * summary.rows_per_bin + (summary.rows_per_bin - 1) / 2) * group.period
    return np.asarray((rows + run.start_tick) / float(run.base_rate), np.float64)


def draw_series(
    axis: Any,
    run: Run,
    names: Mapping[str, str],
    summaries: Mapping[str, ColumnSummary],
    unit: str,
) -> None:
    """Envelopes of signals (name -> label): a line through the middle, filled from end to end."""
    for index, (name, label) in enumerate(names.items()):
        summary = summaries[name]
        time = bin_times(run, run[name].group, summary)
        colour = COLOURS[index % len(COLOURS)]
        style = "-" if index < len(COLOURS) else "--"
        axis.fill_between(time, summary.lows, summary.highs, color=colour, alpha=0.3, linewidth=0)
        middle = (summary.lows + summary.highs) / 2
        width = thickness(index) if len(names) > 1 else 1.0
        axis.plot(time, middle, style, color=colour, linewidth=width, label=label)
    axis.set_ylabel(unit or "1")
    legend_above(axis)


def draw_forces(
    axis: Any,
    run: Run,
    contacts: Sequence[Contact],
    summaries: Mapping[str, ColumnSummary],
) -> None:
    """Normal forces of the users' own fingers (N), and what peers' fingers do to each copy.

    Of the peers' the band from the least to the greatest is drawn, one for each copy.
    """
    own = {c.normal_force: str(c) for c in contacts if c.is_own and c.normal_force}
    copies: dict[str, list[str]] = {}
    for contact in contacts:
        if not contact.is_own and contact.normal_force:
            copies.setdefault(contact.copy, []).append(contact.normal_force)
    for index, (copy, names) in enumerate(copies.items()):
        first = summaries[names[0]]
        time = bin_times(run, run[names[0]].group, first)
        lows = np.min([summaries[name].lows for name in names], axis=0)
        highs = np.max([summaries[name].highs for name in names], axis=0)
        look = HATCHES[index % len(HATCHES)]
        axis.fill_between(
            time,
            lows,
            highs,
            facecolor="0.85",
            edgecolor="0.45",
            linewidth=0.6,
            hatch=look,
            label=f"{copy}, peers' fingers",
            zorder=1,
        )
    axis.set_title("Normal forces of the fingers")
    draw_series(axis, run, own, summaries, "N")


HATCHES = ("", "////", "....", "\\\\\\\\")
"""Of the bands of peers, one for each copy."""


def draw_drift(axis: Any, run: Run, platform: RecordedPlatform) -> None:
    """Distance between the copies of the box (mm); of many pairs the farthest is named."""
    found: dict[str, tuple[NDArray[np.float64], ColumnSummary]] = {}
    for one, other in combinations(platform.copies, 2):
        target = Target("", platform.poses[one][:2], platform.poses[other][:2], is_norm=True)
        group = min((run[name].group for name in target.signals), key=lambda group: group.period)
        statistics = ColumnStatistics(np.array([True]), max(1, group.rows))
        for _, values in blocks(run, target, 0, run.ticks):
            statistics.update(np.ascontiguousarray(1e3 * values).view(np.int64)[None])
        summary = statistics.summary(0)
        found[f"{one} – {other}"] = bin_times(run, group, summary), summary
    farthest = max(found, key=lambda pair: found[pair][1].statistics.maximum)
    named = [*found] if len(found) <= NAMED_PAIRS else [farthest]
    for pair, (time, summary) in found.items():
        colour = COLOURS[(named.index(pair) + 2) % len(COLOURS)] if pair in named else "0.6"
        axis.fill_between(time, summary.lows, summary.highs, color=colour, alpha=0.3, linewidth=0)
        label = pair if pair in named else None
        axis.plot(time, summary.highs, color=colour, linewidth=1.0, label=label)
    axis.set_title("Distance between copies of the box")
    axis.set_ylabel("mm")
    axis.set_ylim(bottom=0)
    legend_above(axis)


NAMED_PAIRS = 3
"""Pairs of copies that are named; of more, the farthest one alone."""


def draw_contacts(
    axis: Any, run: Run, contacts: Sequence[Contact], summaries: Mapping[str, ColumnSummary]
) -> None:
    """A band for each contact; a bin in which it was lost even for a tick shows as free."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    colours = ListedColormap([colour for _, colour in CONTACT_STATES])
    for row, contact in enumerate(contacts):
        summary = summaries[contact.state]
        states = np.where(summary.lows == 0, 0, summary.highs)
        width = summary.rows_per_bin * run[contact.state].group.period / float(run.base_rate)
        edges = run.span[0] + np.arange(states.size + 1) * width
        axis.pcolormesh(
            edges, [row - 0.36, row + 0.36], states[None], cmap=colours, vmin=-0.5, vmax=3.5
        )
    axis.set_yticks(range(len(contacts)), [str(contact) for contact in contacts], fontsize=7.5)
    axis.set_ylim(len(contacts) - 0.4, -0.6)
    axis.grid(visible=False)
    axis.set_title("Contact states")
    legend_above(axis, handles=[Patch(color=c, label=name) for name, c in CONTACT_STATES])
