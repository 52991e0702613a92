"""A figure of a run's signals in one call, shown by a notebook where it is called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.plot.figure import draw
from cosim.plot.kinds import KINDS
from cosim.plot.series import Span, select
from cosim.record.reader import Run


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure in a file."""

    file: Path

    def _repr_png_(self) -> bytes | None:
        return self.file.read_bytes() if self.file.suffix == ".png" else None

    def _repr_svg_(self) -> str | None:
        return self.file.read_text(encoding="utf-8") if self.file.suffix == ".svg" else None


def picture_of(
    runs: Sequence[Run],
    patterns: Sequence[str],
    kind: str,
    window: tuple[str | float, str | float | None],
    file: Path,
) -> Picture:
    """Draw signals of one or several runs from one time to another (s).

    Raises:
        InputError: no such kind, signal or time, or the file cannot be written.
    """
    if kind not in KINDS:
        raise InputError(f"{kind}: is no kind of figure; there are {', '.join(KINDS)}.")
    start, until = (None if time is None else _seconds(time) for time in window)
    span = Span(start or Fraction(0), until)
    draw(KINDS[kind](select(runs, patterns or ["*"]), span), file)
    return Picture(file)


def _seconds(time: str | float) -> Fraction:
    try:
        return quantity(time if isinstance(time, str) else float(time), "s")
    except QuantityError as error:
        raise InputError(str(error)) from None
