"""The results of a sweep as labelled arrays, and a few lines to read."""

from __future__ import annotations

import importlib
import math
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from cosim.base.errors import InputError
from cosim.sweep.results.table import columns_of, failures_text, units_of

if TYPE_CHECKING:
    from cosim.sweep.job import RunResult
    from cosim.sweep.sweep import SweepOutcome

FAILURES = 5
"""Runs that are not good, of which a reader is told first."""


def to_dataframe(outcome: SweepOutcome) -> Any:
    """A pandas table; ``attrs["units"]`` has the units of the variables."""
    frame = _needed("pandas").DataFrame(columns_of(outcome)).set_index("number")
    frame.attrs["units"] = units_of(outcome)
    return frame


def to_xarray(outcome: SweepOutcome) -> Any:
    """An xarray dataset with a dimension for each variable; NaN where a grid's point was not run.

    Raises:
        InputError: the points are a sample, which no grid holds.
    """
    xarray = _needed("xarray")
    axes = outcome.plan.axes
    shape = tuple(len(axis.values) for axis in axes)
    places = [_place(outcome, result, shape) for result in outcome.results]
    columns = columns_of(outcome)
    names = [axis.name for axis in axes]
    found: dict[str, Any] = {}
    for name, values in columns.items():
        if name in {*names, "number", "message", "status"}:
            continue
        array = np.full(shape, np.nan)
        for place, value in zip(places, values, strict=True):
            array[place] = np.nan if value is None else float(value)
        found[name] = (names, array)
    coords = {axis.name: (axis.name, [_plain(v) for v in axis.values]) for axis in axes}
    return xarray.Dataset(found, coords=coords, attrs={"folder": str(outcome.folder)})


def _place(outcome: SweepOutcome, result: RunResult, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Where a point of a grid lies.

    Raises:
        InputError: it is one of a sample.
    """
    axes = outcome.plan.axes
    if result.number < math.prod(shape):
        place = tuple(int(index) for index in np.unravel_index(result.number, shape))
        if all(axis.values[at] == v for axis, at, v in zip(axes, place, result.point, strict=True)):
            return place
    raise InputError("the points are a sample: take to_dataframe().")


def outline(outcome: SweepOutcome) -> str:
    """What came out, in about a dozen lines."""
    counts = Counter(result.status for result in outcome.results)
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    lines = [f"Sweep of {outcome.plan.name} in {outcome.folder}: {told}"]
    lines += [
        f"  {axis.name}: {len(axis.values)} values into {', '.join(axis.places)}"
        for axis in outcome.plan.axes
    ]
    names = [axis.name for axis in outcome.plan.axes]
    return "\n".join([*lines, *failures_text(outcome.failures, names, FAILURES)])


def _plain(value: Any) -> Any:
    from cosim.sweep.planning.axis import number_of

    number = number_of(value)
    return value if number is None else number


def _needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(f"this needs {module}: pip install 'cohaptic[notebook]'.") from None
