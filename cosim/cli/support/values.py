"""What options take: numbers in a range, never NaN or infinite, and places that can be written."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path
from typing import Any

import click

from cosim.plot.style import FORMATS as FIGURES
from cosim.plot.style import PAGE_FORMAT

LONGEST_WATCH = 1e7
"""Seconds, some four months: no watching, waiting or measuring is meant to be longer."""
PLOTS = (*FIGURES, PAGE_FORMAT)
"""What signals can be drawn as: pictures, and a page for a browser."""


class Number(click.FloatRange):
    """A finite number between two ends."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The number; comparisons with NaN refuse nothing, so it is refused by name."""
        number = super().convert(value, param, ctx)
        if number - number != 0.0:
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


class Quantity(click.ParamType[Fraction]):
    """A number with its unit, such as ``2.5 s`` or ``80 ms``; without one it is in ``unit``."""

    name = "quantity"

    def __init__(self, unit: str) -> None:
        self._unit = unit

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Fraction:
        """The exact value in ``unit``, not negative."""
        from cosim.base.quantities.quantity import QuantityError, quantity

        if isinstance(value, Fraction):
            return value
        try:
            found = quantity(value, self._unit)
        except QuantityError as error:
            self.fail(str(error), param, ctx)
        if found < 0:
            self.fail(f"{value} is negative.", param, ctx)
        return found


def seconds(*, zero: bool = False) -> Number:
    """A time span; ``zero`` allows none at all."""
    return Number(0, LONGEST_WATCH, min_open=not zero)


class OutputFile(click.Path):
    """A file to be written; refused at once, not after minutes of work for it."""

    def __init__(self, suffixes: tuple[str, ...] = ()) -> None:
        super().__init__(path_type=Path)
        self._suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if self._suffixes and path.suffix.lower() not in self._suffixes:
            self.fail(f"{path} has to end in {', '.join(self._suffixes)}.", param, ctx)
        if path.is_dir():
            self.fail(f"{path} is a folder; give a file.", param, ctx)
        if not path.parent.is_dir():
            self.fail(f"there is no folder {path.parent} to write {path.name} into.", param, ctx)
        if not os.access(path if path.exists() else path.parent, os.W_OK):
            self.fail(f"{path} cannot be written: permission denied.", param, ctx)
        return path


class OutputFolder(click.Path):
    """A folder to be written into, which may have to be made."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        there = next(each for each in (path, *path.absolute().parents) if each.exists())
        if not there.is_dir():
            self.fail(f"{there} is a file; give a folder.", param, ctx)
        if not os.access(there, os.W_OK):
            self.fail(f"{there} cannot be written: permission denied.", param, ctx)
        return path
