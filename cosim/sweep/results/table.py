"""The results of a sweep as one table: a row a run, a column a variable, measure or verdict."""

from __future__ import annotations

import csv
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.report.measures import SCENARIO_MEASURES
from cosim.sweep.job import RunResult
from cosim.sweep.planning.axis import number_of
from cosim.sweep.sweep import SweepOutcome

Columns = dict[str, list[Any]]
FORMATS = (".parquet", ".csv")


def columns_of(outcome: SweepOutcome) -> Columns:
    """The table by column: numbers without their units, which stand in ``units_of``."""
    results = outcome.results
    found: Columns = {"number": [result.number for result in results]}
    for place, axis in enumerate(outcome.plan.axes):
        values = [result.point[place] for result in results]
        found[axis.name] = values if axis.has_words else list(map(_plain, values))
    found["status"] = [result.status for result in results]
    for name in _names([result.measures for result in results]):
        found[name] = [result.measures.get(name) for result in results]
    for name in _names([result.passed for result in results]):
        found[f"{name} met"] = [result.passed.get(name) for result in results]
    if outcome.theory is not None:
        found["spectral_radius"] = [outcome.theory[result.number] for result in results]
    for name in ("ticks", "seconds", "checked", "message"):
        found[name] = [getattr(result, name) for result in results]
    return found


def units_of(outcome: SweepOutcome) -> dict[str, str]:
    """The units in which the plan writes its variables, and those of measures and of times."""
    units = {name: each.unit for name, each in SCENARIO_MEASURES.items() if each.unit}
    units |= {"seconds": "s"}
    return units | {axis.name: axis.unit for axis in outcome.plan.axes if axis.unit}


def write_table(outcome: SweepOutcome, file: Path) -> None:
    """Write the table as CSV or Parquet, as the file's name says.

    Raises:
        InputError: another format, what it needs is not installed, or the file cannot be written.
    """
    write_columns(columns_of(outcome), units_of(outcome), file)


def write_columns(columns: Columns, units: Mapping[str, str], file: Path) -> None:
    """Write columns of one length as CSV or Parquet, as the file's name says.

    Raises:
        InputError: another format, what it needs is not installed, or the file cannot be written.
    """
    match file.suffix.lower():
        case ".csv":
            _write_csv(columns, file)
        case ".parquet":
            _write_parquet(columns, units, file)
        case _:
            raise InputError(f"{file}: a table ends in {' or '.join(FORMATS)}.")


def best_format() -> str:
    """Parquet where something that writes it is installed, else CSV."""
    from importlib.util import find_spec

    return ".parquet" if find_spec("pyarrow") is not None else ".csv"


def _names(mappings: Sequence[Mapping[str, Any]]) -> list[str]:
    return list(dict.fromkeys(name for each in mappings for name in each))


def _plain(value: Any) -> Any:
    number = number_of(value) if isinstance(value, str) else None
    return value if number is None else number


def _write_csv(columns: Columns, file: Path) -> None:
    with writing(file), file.open("w", newline="", encoding="utf-8") as out:
        lines = csv.writer(out)
        lines.writerow(columns)
        lines.writerows(map(_cells, zip(*columns.values(), strict=True)))


def _cells(row: Sequence[Any]) -> list[Any]:
    texts = {True: "true", False: "false"}
    return ["" if cell is None else texts[cell] if isinstance(cell, bool) else cell for cell in row]


def _write_parquet(columns: Columns, units: Mapping[str, str], file: Path) -> None:
    try:
        arrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise InputError("Parquet needs pyarrow: pip install 'cohaptic[export]'.") from None
    arrays = {name: _one_type(values) for name, values in columns.items()}
    table: Any = arrow.table(arrays)
    fields = [
        field.with_metadata({"unit": units[field.name]}) if field.name in units else field
        for field in table.schema
    ]
    with writing(file):
        parquet.write_table(table.cast(arrow.schema(fields)), file)


def _one_type(values: list[Any]) -> list[Any]:
    """A column of one type: words where there is one, or where true stands beside a number."""
    there = [value for value in values if value is not None]
    truths = sum(isinstance(value, bool) for value in there)
    if truths in {0, len(there)} and not any(isinstance(value, str) for value in there):
        return values
    return [None if v is None else _word(v) for v in values]


def _word(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def failures_text(results: Sequence[RunResult], axes: Sequence[str], most: int = 10) -> list[str]:
    """A line for each run that is not good."""
    lines: list[str] = []
    for result in results[:most]:
        values = ", ".join(
            f"{name} = {value}" for name, value in zip(axes, result.point, strict=True)
        )
        lines.append(f"  {result.status:8s} {values}: {result.message.splitlines()[0]}")
    if len(results) > most:
        lines.append(f"  and {len(results) - most} more")
    return lines
