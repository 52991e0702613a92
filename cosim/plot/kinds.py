"""What can be drawn of series: over time, difference, spectrum, phase plane, histogram.

Each kind takes the series and returns panels; a panel is one pair of axes with its lines.
To have another kind, add a function to ``KINDS``.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, cast

import numpy as np

from cosim.base.errors import InputError
from cosim.plot.series import Numbers, Span, TimeSeries, held_together

Form = Literal["steps", "line", "bars"]


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a panel: ``x`` and ``y`` of one shape, or with bars one more of ``x``."""

    label: str
    x: Numbers
    y: Numbers


@dataclass(frozen=True, slots=True)
class Panel:
    """A pair of axes: what stands along them, how it is drawn, and its lines."""

    x: str
    y: str
    lines: tuple[Line, ...]
    form: Form = "steps"
    is_logarithmic: bool = False
    is_square: bool = False
    """One unit is as long along both axes."""
    items: Mapping[int, str] = field(default_factory=dict[int, str])
    """Names of values along y."""
    title: str = ""
    """What all lines have in common."""


def over_time(series: Sequence[TimeSeries], span: Span) -> list[Panel]:
    """As recorded, each value held until the next: a panel for each unit."""
    units: dict[str, list[TimeSeries]] = {}
    for each in series:
        items = "".join(f"{value}{name}" for value, name in each.signal.column.items)
        units.setdefault(f"{each.unit}{items}", []).append(each)
    panels: list[Panel] = []
    for of in units.values():
        title, labels = _named(of)
        lines = (Line(x, *each.values(span)) for x, each in zip(labels, of, strict=True))
        items = dict(of[0].signal.column.items)
        panels.append(
            Panel("time (s)", "" if items else of[0].unit, tuple(lines), items=items, title=title)
        )
    return panels


def difference(series: Sequence[TimeSeries], span: Span) -> list[Panel]:
    """The first run's signals less those of each other run; of one run, the first less the rest."""
    by_name: dict[str, list[TimeSeries]] = {}
    several = len({each.run.folder for each in series}) > 1
    for each in series:
        by_name.setdefault(each.name if several else "", []).append(each)
    panels: list[Panel] = []
    for of in by_name.values():
        first, *others = of
        if not others:
            raise InputError(
                f"a difference of {first.label} alone: name a second signal, or a second run that "
                "recorded it."
            )
        lines: list[Line] = []
        for other in others:
            if other.unit != first.unit:
                raise InputError(
                    f"{first.label} is in {first.unit} and {other.label} in {other.unit}: they "
                    "have no difference."
                )
            time, one, two = held_together(first, other, span)
            name = f"{first.run_name or first.name} − {other.run_name or other.name}"
            lines.append(Line(name, time, one - two))
        title = first.name if several else ""
        panels.append(Panel("time (s)", first.unit, tuple(lines), title=title))
    return panels


def spectrum(series: Sequence[TimeSeries], span: Span) -> list[Panel]:
    """Amplitude spectral density (unit/√Hz) by Welch's method (1967), Hann windows."""
    welch: Any = importlib.import_module("scipy.signal").welch

    units: dict[str, list[tuple[TimeSeries, Numbers, Numbers]]] = {}
    for each in series:
        _, values = each.values(span)
        if values.size < SHORTEST_SPECTRUM or not np.isfinite(values).all():
            raise InputError(
                f"{each.label}: a spectrum needs {SHORTEST_SPECTRUM} finite values and there are "
                f"{int(np.isfinite(values).sum())} in this span."
            )
        length = 1 << max(4, int(np.log2(values.size)) - 2)
        frequency, power = cast(
            "tuple[Numbers, Numbers]", welch(values, float(1 / each.period), nperseg=length)
        )
        units.setdefault(each.unit, []).append((each, frequency[1:], np.sqrt(power[1:])))
    panels: list[Panel] = []
    for unit, of in units.items():
        title, labels = _named([each for each, _, _ in of])
        lines = tuple(Line(name, x, y) for name, (_, x, y) in zip(labels, of, strict=True))
        panels.append(
            Panel("frequency (Hz)", f"{unit}/√Hz", lines, "line", is_logarithmic=True, title=title)
        )
    return panels


SHORTEST_SPECTRUM = 64
"""Fewest values of which there is a spectrum."""


def phase_plane(series: Sequence[TimeSeries], span: Span) -> list[Panel]:
    """The second of two signals over the first, a line for each run."""
    runs: dict[str, list[TimeSeries]] = {}
    for each in series:
        runs.setdefault(str(each.run.folder), []).append(each)
    lines: list[Line] = []
    for of in runs.values():
        if len(of) != 2:
            raise InputError(
                f"a phase plane takes two signals of a run, x and y, and {len(of)} are named: "
                f"{', '.join(each.name for each in of[:4])}."
            )
        one, two = of
        _, x, y = held_together(one, two, span)
        lines.append(Line(one.run_name, x, y))
    one, two = next(iter(runs.values()))
    return [
        Panel(
            f"{one.name} ({one.unit})",
            f"{two.name} ({two.unit})",
            tuple(lines),
            "line",
            is_square=one.unit == two.unit,
        )
    ]


def histogram(series: Sequence[TimeSeries], span: Span) -> list[Panel]:
    """Share of the rows in bins that all series of a unit have in common."""
    units: dict[str, list[TimeSeries]] = {}
    for each in series:
        units.setdefault(each.unit, []).append(each)
    panels: list[Panel] = []
    for unit, of in units.items():
        known = [values[np.isfinite(values)] for _, values in (t.values(span) for t in of)]
        everything = np.concatenate(known)
        if not everything.size:
            raise InputError(f"{of[0].label}: no value in this span is finite.")
        if all(not each.signal.is_float for each in of):
            edges = np.arange(float(everything.min()), float(everything.max()) + 2.0) - 0.5
        else:
            edges = _edges(everything)
        title, labels = _named(of)
        lines = tuple(
            Line(name, edges, np.histogram(values, edges)[0] / max(1, values.size))
            for name, values in zip(labels, known, strict=True)
        )
        panels.append(Panel(unit, "share of the rows", lines, "bars", title=title))
    return panels


def _edges(values: Numbers) -> Numbers:
    """Of bins by Freedman and Diaconis's rule (1981), ten to a hundred of them."""
    low, high = np.percentile(values, [25, 75])
    least, greatest = float(values.min()), float(values.max())
    if least == greatest:
        return np.linspace(least - 0.5, least + 0.5, FEWEST_BINS + 1)
    width = 2 * (high - low) / np.cbrt(values.size)
    bins = MOST_BINS if width == 0.0 else int(np.ceil((greatest - least) / width))
    return np.linspace(least, greatest, min(MOST_BINS, max(FEWEST_BINS, bins)) + 1)


FEWEST_BINS, MOST_BINS = 10, 100


def _named(of: Sequence[TimeSeries]) -> tuple[str, list[str]]:
    """What the series have in common, and what tells them apart."""
    names = {each.name for each in of}
    if len(names) == 1:
        return names.pop(), [each.run_name for each in of]
    return "", [each.label for each in of]


KINDS: Mapping[str, Callable[[Sequence[TimeSeries], Span], list[Panel]]] = {
    "time": over_time,
    "difference": difference,
    "spectrum": spectrum,
    "phase": phase_plane,
    "histogram": histogram,
}
