"""Recorded signals as labelled arrays: a pandas table, an xarray dataset, a few lines to read."""

from __future__ import annotations

import html
import importlib
from collections.abc import Sequence
from typing import Any

from cosim.base.errors import InputError
from cosim.record.export.formats import chosen
from cosim.record.export.table import Table
from cosim.record.reader import Run

SHOWN = 6
"""Signals of a group that a reader is shown."""


def to_dataframe(run: Run, patterns: Sequence[str] = ()) -> Any:
    """A pandas table: a row a time (s), a column a signal, slower signals held.

    ``frame.attrs["units"]`` has the unit of each column.

    Raises:
        InputError: a pattern matches nothing, or pandas is not installed.
    """
    pandas = _needed("pandas")
    table = _table(run, patterns)
    columns = {signal.name: table.values(signal, 0, table.rows) for signal in table.signals}
    time = run.seconds(table.ticks(0, table.rows))
    frame = pandas.DataFrame(columns, index=pandas.Index(time, name="time"))
    frame.attrs["units"] = {signal.name: signal.unit for signal in table.signals}
    return frame


def to_xarray(run: Run, patterns: Sequence[str] = ()) -> Any:
    """An xarray dataset: each signal over its own times (s), with its unit and description.

    Raises:
        InputError: a pattern matches nothing, or xarray is not installed.
    """
    xarray = _needed("xarray")
    signals = chosen(run, patterns)
    groups = {signal.group.name: signal.group for signal in signals}
    names = {name: "time" if len(groups) == 1 else f"time_{name}" for name in groups}
    variables = {
        signal.name: (
            names[signal.group.name],
            signal.values,
            {"units": signal.unit, "long_name": signal.description},
        )
        for signal in signals
    }
    times = {
        names[name]: (names[name], group.time, {"units": "s"}) for name, group in groups.items()
    }
    return xarray.Dataset(variables, coords=times, attrs={"run": str(run.folder)})


def outline(run: Run) -> str:
    """What is in a run, in about a dozen lines."""
    title = run.manifest.get("scenario", {}).get("title", "")
    seconds = float(run.ticks / run.base_rate)
    lines = [f"Run {run.folder}: {title}".rstrip(": "), f"  {seconds:g} s, {run.ticks} ticks"]
    for group in run.groups.values():
        lines.append(
            f"  {group.name}: {group.rate} Hz, {group.rows} rows, {len(group.signals)} signals"
        )
        shown = list(group.signals.values())[:SHOWN]
        lines += [f"    {signal.name} {signal.unit}".rstrip() for signal in shown]
        if len(group.signals) > SHOWN:
            lines.append(f"    and {len(group.signals) - SHOWN} more")
        lines += [
            f"    {text.name} (text, {len(text.changes)} changes)" for text in group.texts.values()
        ]
    return "\n".join(lines)


def outline_html(run: Run) -> str:
    """The same for a notebook."""
    rows = "".join(
        f"<tr><td>{html.escape(signal.name)}</td><td>{html.escape(signal.unit)}</td>"
        f"<td>{group.rate} Hz</td><td>{html.escape(signal.description)}</td></tr>"
        for group in run.groups.values()
        for signal in list(group.signals.values())[:SHOWN]
    )
    head = html.escape(outline(run).splitlines()[0])
    return (
        f"<p>{head}</p><table><tr><th>signal</th><th>unit</th><th>rate</th><th></th></tr>"
        f"{rows}</table>"
    )


def _table(run: Run, patterns: Sequence[str]) -> Table:
    signals = chosen(run, patterns)
    period = min((signal.group.period for signal in signals), default=1)
    covered = min((s.group.rows * s.group.period for s in signals), default=0)
    return Table("", run, period, covered // period, tuple(signals))


def _needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(f"this needs {module}: pip install 'cohaptic[notebook]'.") from None
