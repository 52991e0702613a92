"""A run in other formats. Nothing is interpolated: each group keeps its own rows and ticks.

``csv`` and ``parquet`` get one file for each group; ``mat``, ``mf4`` and ``mcap`` one file with a
struct, a channel group or a topic for each. The first columns are the base tick and the time (s).
With ``held`` everything is put on the fastest group's rows instead, slower signals held as they
were, in one table. Texts get a table of their changes.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.base.wildcard import compile_wildcard
from cosim.record.export.mcap import write_mcap
from cosim.record.export.mdf import write_mdf
from cosim.record.export.table import Span, Table, needed
from cosim.record.export.texts import ChangeTable, text_tables
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal

OWN_FIELDS = frozenset({"tick", "time", "units", "names"})
"""Of each struct, besides its signals."""
MATLAB_NAME_LENGTH = 63
"""Longest name of a struct's field in MATLAB."""


def export(
    run: Run,
    kind: str,
    folder: Path,
    *,
    held: bool = False,
    patterns: Sequence[str] = (),
    span: Span = (0, None),
) -> list[Path]:
    """Write a run in ``kind`` into ``folder``; returns the files.

    Names, and patterns with ``*`` and ``?``, choose signals, ``span`` the base ticks.

    Raises:
        InputError: the kind is unknown, or the package that it needs is not installed; nothing is
            recorded, a pattern matches nothing or nothing is in the span; or ``folder`` cannot be
            written.
    """
    if kind not in EXPORTERS:
        raise InputError(f"{kind}: is no export format; there are {', '.join(EXPORTERS)}.")
    if not run.signals and not run.texts:
        raise InputError(f"{run.folder}: nothing is recorded in it, so nothing can be exported.")
    signals, texts = chosen(run, patterns), chosen_texts(run, patterns)
    tables = [_held_table(run, signals)] if held and signals else _tables(run, signals)
    tables = [part for table in tables if (part := table.within(span)).rows]
    changes = text_tables(run, texts, span)
    if not tables and not changes:
        raise InputError(f"{run.folder}: no row lies in the time that is to be exported.")
    with writing(folder, "--out takes a folder for the files"):
        folder.mkdir(parents=True, exist_ok=True)
        return EXPORTERS[kind](tables, changes, folder)


def chosen(run: Run, patterns: Collection[str]) -> list[RecordedSignal]:
    """The signals that names and patterns mean; all of them without one.

    Raises:
        InputError: a pattern matches nothing.
    """
    found: dict[str, None] = {}
    for pattern in patterns:
        expression = compile_wildcard(pattern)
        names = [name for name in run.signals if expression.fullmatch(name)]
        if not names and not any(map(expression.fullmatch, run.texts)):
            names = [run[pattern].name]  # refuses, and says what comes near
        found |= dict.fromkeys(names)
    return [run.signals[name] for name in (found if patterns else run.signals)]


def chosen_texts(run: Run, patterns: Iterable[str]) -> list[str]:
    """The texts that names and patterns mean; all of them without one."""
    expressions = [compile_wildcard(pattern) for pattern in patterns]
    return [
        name
        for name in run.texts
        if not expressions or any(expression.fullmatch(name) for expression in expressions)
    ]


def _tables(run: Run, signals: Sequence[RecordedSignal]) -> list[Table]:
    """A table for each group that has some of the signals."""
    names = {signal.name for signal in signals}
    parts = {
        name: tuple(group.signals[each] for each in group.signals if each in names)
        for name, group in run.groups.items()
    }
    return [
        Table(name, run, run.groups[name].period, run.groups[name].rows, members)
        for name, members in parts.items()
        if members
    ]


def _held_table(run: Run, signals: Sequence[RecordedSignal]) -> Table:
    period = min(signal.group.period for signal in signals)
    rows = -(-run.ticks // period)
    return Table("held", run, period, rows, tuple(signals))


def _write_csv(tables: list[Table], texts: list[ChangeTable], folder: Path) -> list[Path]:
    """Numbers as the shortest text that reads back to the same double; units in the second line."""
    paths: list[Path] = []
    for table in tables:
        path = folder / f"{table.name}.csv"
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["tick", "time", *(signal.name for signal in table.signals)])
            writer.writerow(["1", "s", *(signal.unit or "1" for signal in table.signals)])
            for first, last in table.pieces():
                ticks = table.ticks(first, last)
                columns = [table.values(signal, first, last) for signal in table.signals]
                every = [ticks, table.run.seconds(ticks), *columns]
                writer.writerows(zip(*(column.tolist() for column in every), strict=True))
        paths.append(path)
    for text in texts:
        path = folder / f"{text.name}.csv"
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["tick", "time", "signal", "value"])
            times = text.run.seconds(text.ticks).tolist()
            writer.writerows(
                (tick, time, signal, value)
                for (tick, signal, value), time in zip(text.rows, times, strict=True)
            )
        paths.append(path)
    return paths


def _write_mat(tables: list[Table], texts: list[ChangeTable], folder: Path) -> list[Path]:
    """A MAT-file of level 5: a struct for each group with tick, time, signals, names and units."""
    structs = iter(matlab_names([each.name for each in (*tables, *texts)], {"base_rate"}))
    content: dict[str, Any] = {}
    for table in tables:
        ticks = table.ticks(0, table.rows)
        fields = matlab_names([signal.name for signal in table.signals], OWN_FIELDS)
        columns: dict[str, Any] = {
            "tick": ticks[:, None],
            "time": table.run.seconds(ticks)[:, None],
        }
        units: dict[str, str] = {}
        names: dict[str, str] = {}
        for signal, field in zip(table.signals, fields, strict=True):
            columns[field] = table.values(signal, 0, table.rows)[:, None]
            units[field], names[field] = signal.unit, signal.name
        content[next(structs)] = columns | {"units": units, "names": names}
    for text in texts:
        content[next(structs)] = {
            "tick": text.ticks[:, None],
            "time": text.run.seconds(text.ticks)[:, None],
            "signal": np.array(text.signals, dtype=object),
            "value": np.array(text.values, dtype=object),
        }
    rate = (tables or texts)[0].run.base_rate
    content["base_rate"] = np.array([[rate.numerator, rate.denominator]], np.int64)
    path = folder / "run.mat"
    needed("mat", "scipy.io").savemat(
        path, content, long_field_names=True, do_compression=True, oned_as="column"
    )
    return [path]


def _write_parquet(tables: list[Table], texts: list[ChangeTable], folder: Path) -> list[Path]:
    """Columns with their units as field metadata; base rate and period as the table's."""
    arrow, parquet = needed("parquet", "pyarrow"), needed("parquet", "pyarrow.parquet")
    paths: list[Path] = []
    for table in tables:
        fields = [arrow.field("tick", arrow.int64()), arrow.field("time", arrow.float64())]
        for signal in table.signals:
            kind = arrow.float64() if signal.is_float else arrow.int64()
            metadata = {"unit": signal.unit, "description": signal.description}
            fields.append(arrow.field(signal.name, kind, metadata=metadata))
        about = {"base_rate": str(table.run.base_rate), "period": str(table.period)}
        schema = arrow.schema(fields, metadata=about)
        path = folder / f"{table.name}.parquet"
        with parquet.ParquetWriter(path, schema) as writer:
            for first, last in table.pieces():
                ticks = table.ticks(first, last)
                columns = [table.values(signal, first, last) for signal in table.signals]
                arrays = [arrow.array(c) for c in (ticks, table.run.seconds(ticks), *columns)]
                writer.write_batch(arrow.record_batch(arrays, schema=schema))
        paths.append(path)
    for text in texts:
        path = folder / f"{text.name}.parquet"
        columns = {
            "tick": text.ticks,
            "time": text.run.seconds(text.ticks),
            "signal": arrow.array(text.signals, arrow.string()),
            "value": arrow.array(text.values, arrow.string()),
        }
        parquet.write_table(arrow.table(columns), path)
        paths.append(path)
    return paths


def matlab_names(names: Sequence[str], taken: Collection[str] = ()) -> list[str]:
    """Names of struct fields: ``vr_a.finger_1.force[2]`` becomes ``vr_a_finger_1_force_2``.

    Too long or equal ones, and those that are taken, end in a number; the struct's ``names`` holds
    the originals.
    """
    found: list[str] = []
    for name in names:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
        plain = plain if plain[:1].isalpha() else f"x_{plain}"
        short = plain[:MATLAB_NAME_LENGTH]
        number = 1
        while short in found or short in taken:
            number += 1
            tail = f"_{number}"
            short = plain[: MATLAB_NAME_LENGTH - len(tail)] + tail
        found.append(short)
    return found


EXPORTERS: Mapping[str, Callable[[list[Table], list[ChangeTable], Path], list[Path]]] = {
    "csv": _write_csv,
    "mat": _write_mat,
    "mcap": write_mcap,
    "mf4": write_mdf,
    "parquet": _write_parquet,
}
