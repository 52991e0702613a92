"""A table in a text file: a heading that names its columns with their units, then a row a time.

    t [s], x [mm], y [mm]
    0.00, 12.5, 3
    0.01, 12.6, 3.1

Columns are separated by commas, semicolons, tabs or spaces, as the heading has it. Empty lines and
lines that begin with ``#`` are skipped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.base.document.text_file import read_text
from cosim.base.document.typography import comma_in_number
from cosim.base.errors import InputError, Location
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.quantities.unit_hint import unit_hint
from cosim.base.quantities.units import UnitError, parse_unit, unit_of
from cosim.base.suggest import did_you_mean

TIME = ("t", "time")
"""What the column of the times may be called."""
_NAME = r"[^\W\d]\w*(?:\.[^\W\d]\w*)*"
_COLUMN = re.compile(rf"\s*\"?({_NAME})\s*(?:\[([^\]]*)\])?\"?\s*")
_SEPARATORS = (",", ";", "\t")
_LINE = re.compile(r"\r\n|\r|\n")
"""What ends a line for an editor, which counts the others as characters."""
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+")


@dataclass(frozen=True, slots=True)
class Heading:
    """The names and units of the columns, in their order; a unit is empty where none is written."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    separator: str | None
    """``None``: any white space."""
    line: int


@dataclass(frozen=True, slots=True, eq=False)
class TableFile:
    """Some columns of a table: ``times`` (rows,) in s, rising; ``values`` (rows, columns)."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    times: NDArray[np.float64]
    values: NDArray[np.float64]


def read_table(file: Path, columns: Sequence[str] = ()) -> TableFile:
    """The columns of that name, or all of them, in their own units.

    Raises:
        InputError: the file cannot be read or is no such table, with the line and column of what
            is wrong; or it has no such column.
    """
    lines = _LINE.split(read_text(file, str(file)))
    heading = _heading(file, lines)
    clock, chosen = _chosen(file, heading, columns)
    rows = _numbers(file, lines, heading, (clock, *chosen))
    with np.errstate(over="ignore"):  # a time beyond all numbers is found below
        times = rows[:, 0] * _second(file, heading, clock)
    _check_times(file, lines, heading, times)
    names, units = ([each[i] for i in chosen] for each in (heading.names, heading.units))
    return TableFile(tuple(names), tuple(units), times, np.ascontiguousarray(rows[:, 1:]))


def _data(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Number and text of every line that says something."""
    for number, line in enumerate(lines, 1):
        if (text := line.strip()) and not text.startswith("#"):
            yield number, line


def _heading(file: Path, lines: Sequence[str]) -> Heading:
    number, line = next(_data(lines), (1, ""))
    if not line:
        raise InputError("there is nothing in this file.", Location(str(file), 1, 1))
    separator = next((each for each in _SEPARATORS if each in line), None)
    # White space may stand between a name and its unit, too.
    fields = line.split(separator) if separator else re.findall(r"[^\s\[]+\s*(?:\[[^\]]*\])?", line)
    names: list[str] = []
    units: list[str] = []
    for place, field in enumerate(fields, 1):
        found = _COLUMN.fullmatch(field)
        if found is None:
            raise InputError(
                f"column {place} of the heading is '{field.strip()}'; write a name, and its unit "
                "in brackets, as in 'x [mm]'.",
                Location(str(file), number, 1 + line.find(field.strip())),
            )
        if found[1] in names:
            twice = Location(str(file), number, 1 + line.rfind(found[1]))
            raise InputError(f"two columns are called {found[1]}.", twice)
        names.append(found[1])
        units.append((found[2] or "").strip())
    return Heading(tuple(names), tuple(units), separator, number)


def _chosen(file: Path, heading: Heading, columns: Sequence[str]) -> tuple[int, tuple[int, ...]]:
    at = Location(str(file), heading.line, 1)
    clock = _clock(heading, at)
    others = [name for i, name in enumerate(heading.names) if i != clock]
    for name in columns:
        if name not in others:
            raise InputError(f"there is no column '{name}'.{did_you_mean(name, others)}", at)
    if twice := [name for i, name in enumerate(columns) if name in columns[:i]]:
        raise InputError(f"the column '{twice[0]}' is asked for twice.", at)
    wanted = list(columns) or others
    if not wanted:
        raise InputError("there is no column beside that of the times.", at)
    chosen = tuple(heading.names.index(name) for name in wanted)
    for i in chosen:
        _check_unit(heading.names[i], heading.units[i], at)
    return clock, chosen


def _clock(heading: Heading, at: Location) -> int:
    """Which column holds the times; one called just so before one in capitals.

    Raises:
        InputError: none does, or two may.
    """
    alike = [i for i, name in enumerate(heading.names) if name.casefold() in TIME]
    clocks = [i for i in alike if heading.names[i] in TIME] or alike
    if not clocks:
        raise InputError(
            "no column holds the times; call one 't' or 'time', with its unit: 't [ms]'.", at
        )
    if len(clocks) > 1:
        names = " and ".join(heading.names[i] for i in clocks)
        raise InputError(f"{names} may both be the times; call one of them otherwise.", at)
    return clocks[0]


def _check_unit(name: str, unit: str, at: Location) -> None:
    if not unit:
        return
    try:
        parse_unit(unit)
    except UnitError as error:
        hint = unit_hint(unit, lambda text: unit_of(text).exponents is not None)
        raise InputError(f"{name}: {error}{hint}", at) from None


def _second(file: Path, heading: Heading, clock: int) -> float:
    """One of the time's units in seconds."""
    unit = heading.units[clock]
    try:
        return float(quantity(f"1 {unit}", "s")) if unit else 1.0
    except QuantityError as error:
        at = Location(str(file), heading.line, 1)
        raise InputError(f"{heading.names[clock]}: {error}", at) from None


def _numbers(
    file: Path, lines: Sequence[str], heading: Heading, columns: Sequence[int]
) -> NDArray[np.float64]:
    rows = [line for number, line in _data(lines) if number > heading.line]
    if not rows:
        place = Location(str(file), heading.line, 1)
        raise InputError("there is no row below the heading.", place)
    width = len(heading.names)
    if all(len(row.split(heading.separator)) == width for row in rows):
        with suppress(ValueError):
            found = np.loadtxt(
                rows, delimiter=heading.separator, usecols=columns, ndmin=2, comments=None
            )
            if np.isfinite(found).all():
                return found
    raise _first_wrong(file, lines, heading, columns)


def _first_wrong(
    file: Path, lines: Sequence[str], heading: Heading, columns: Sequence[int]
) -> InputError:
    width = len(heading.names)
    for number, line in _data(lines):
        if number <= heading.line:
            continue
        fields = line.split(heading.separator)
        if len(fields) != width:
            message = f"there are {len(fields)} columns; the heading has {width}."
            return InputError(message, Location(str(file), number, 1))
        for i in columns:
            text = fields[i].strip()
            if not _NUMBER.fullmatch(text) or not np.isfinite(float(text)):
                message = f"{heading.names[i]}: '{text}' is no finite number."
                if _COMMA.fullmatch(text):
                    message = f"{heading.names[i]}: {comma_in_number(text)}"
                column = 1 + (line.find(text) if text else 0)
                return InputError(message, Location(str(file), number, column))
    return InputError("its rows cannot be read as numbers.", Location(str(file), heading.line, 1))


def _check_times(
    file: Path, lines: Sequence[str], heading: Heading, times: NDArray[np.float64]
) -> None:
    late = np.flatnonzero(~np.isfinite(times))
    wrong = np.flatnonzero(np.diff(times[: late[0]] if len(late) else times) <= 0.0)
    if not len(wrong) and not len(late):
        return
    numbers = [number for number, _ in _data(lines) if number > heading.line]
    if not len(wrong):
        at = Location(str(file), numbers[int(late[0])], 1)
        raise InputError("its time in seconds is no finite number.", at)
    first = int(wrong[0])
    raise InputError(
        f"its time is {times[first + 1]:g} s, and that of the row before is {times[first]:g} s; "
        "times have to rise.",
        Location(str(file), numbers[first + 1], 1),
    )
