"""What is varied: a variable, the places in the scenario that take its value, and its values."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, split_quantity

Value = int | float | str | bool
"""As it would be written in the scenario."""

_RANGE = re.compile(
    r"\s*(?P<low>.+?)\s*\.\.\s*(?P<high>.+?)\s*"
    r"(?:/\s*(?P<points>\d+)|:\s*(?P<step>[^:/]+?))?(?P<log>\s+log)?\s*"
)
MOST = 1_000_000
"""Values that an axis may have."""


@dataclass(frozen=True, slots=True)
class Range:
    """The numbers from ``low`` to ``high``, both included, in ``unit``.

    ``is_whole``: whole numbers only, as of a range without a number of points. ``points`` is how
    many a grid takes.
    """

    low: Fraction
    high: Fraction
    unit: str | None
    is_log: bool
    is_whole: bool
    points: int

    def at(self, share: float) -> Value:
        """The value at a share of the way, 0 to 1; whole numbers are equally likely."""
        if self.is_whole:
            count = int(self.high - self.low) + 1
            return self._written(self.low + min(int(share * count), count - 1), whole=True)
        if share in {0.0, 1.0}:
            return self._written(self.high if share else self.low)
        if self.is_log:
            return self._written(float(self.low) * float(self.high / self.low) ** share)
        return self._written(self.low + (self.high - self.low) * Fraction(share))

    def values(self) -> tuple[Value, ...]:
        """The values of a grid."""
        last = max(1, self.points - 1)
        if self.is_log:
            return tuple(self.at(index / last) for index in range(self.points))
        span = self.high - self.low
        numbers = [self.low + span * index / last for index in range(self.points)]
        whole = all(number.denominator == 1 for number in numbers)
        return tuple(self._written(number, whole=whole) for number in numbers)

    def _written(self, number: Fraction | float, *, whole: bool = False) -> Value:
        plain = int(number) if whole else float(number)
        return plain if self.unit is None else f"{plain!r} {self.unit}"


@dataclass(frozen=True, slots=True)
class SweepAxis:
    """One variable of a sweep.

    ``places`` are the paths, as ``--set`` takes them, that get its value. ``span`` is the range
    that its ``values`` come from, where it is one.
    """

    name: str
    places: tuple[str, ...]
    values: tuple[Value, ...]
    span: Range | None = None

    @property
    def unit(self) -> str:
        """The unit that its values are written in; empty for plain numbers and words."""
        units = [unit for value in self.values if (unit := unit_of(value))]
        return "" if self.has_words or not units else units[0]

    @property
    def has_words(self) -> bool:
        """Whether a value is no number: then all stand as they are written."""
        return any(map(is_word, self.values))

    @property
    def is_log(self) -> bool:
        """Whether a figure has to have a logarithmic axis."""
        return self.span is not None and self.span.is_log


def parse_values(name: str, text: str) -> tuple[tuple[Value, ...], Range | None]:
    """The values that a text stands for: ``1, 2, 5``, ``0..39``, ``0..1:0.1``, ``1..100/7 log``.

    Raises:
        InputError: it is none of these.
    """
    match = _RANGE.fullmatch(text)
    if match is None:
        return tuple(_plain(part) for part in _listed(name, text)), None
    span = range_of(
        name,
        match["low"],
        match["high"],
        points=None if match["points"] is None else int(match["points"]),
        step=match["step"],
        is_log=match["log"] is not None,
    )
    return span.values(), span


def range_of(
    name: str,
    low: Value,
    high: Value,
    *,
    points: int | None = None,
    step: Value | None = None,
    is_log: bool = False,
) -> Range:
    """A range by its ends and the number of its points or its step (1 without either).

    Raises:
        InputError: ends of different units, no whole number of steps, or a logarithm of nothing.
    """
    (first, unit), (last, other) = _quantity(name, low), _quantity(name, high)
    if unit is None or other is None:  # '0..20 ms' has its unit once
        unit = other = unit or other
    if unit != other:
        raise InputError(f"{name}: write both ends in one unit, not {unit} and {other}.")
    if first > last:
        raise InputError(f"{name}: the low end {low} lies above the high end {high}.")
    if is_log and first <= 0:
        raise InputError(f"{name}: a logarithmic range begins above 0, not at {low}.")
    if points is not None and step is not None:
        raise InputError(f"{name}: give the number of points or the step, not both.")
    whole = first.denominator == last.denominator == 1
    if points is None:
        if is_log:
            raise InputError(f"{name}: a logarithmic range needs its number of points.")
        if step is None and not whole:
            raise InputError(f"{name}: write how many points there are, as in {low}..{high}/20.")
        size, step_unit = (Fraction(1), None) if step is None else _quantity(name, step)
        if step_unit not in {None, unit}:
            raise InputError(f"{name}: write the step in {unit or 'the same unit'}.")
        if size <= 0 or ((last - first) / size).denominator != 1:
            raise InputError(f"{name}: {low} to {high} is no whole number of steps of {step}.")
        points = int((last - first) / size) + 1
        whole = whole and size.denominator == 1
    else:
        whole = False
    if points == 1 and first != last:
        raise InputError(f"{name}: one point is not both ends, {low} and {high}; write the value.")
    if not 1 <= points <= MOST:
        raise InputError(f"{name}: {points} points; there may be 1 to {MOST}.")
    return Range(first, last, unit, is_log, whole, points)


def check_units(name: str, values: Sequence[Value]) -> None:
    """Numbers of one variable are in one unit, for a table and a figure have one of it.

    Raises:
        InputError: they are in several; a zero needs none.
    """
    units = {unit_of(v) for v in values if not is_word(v) and number_of(v) != 0}
    if len(units) > 1:
        known = " and ".join(sorted(unit or "no unit" for unit in units))
        raise InputError(f"{name}: write all values in one unit, not {known}.")


def number_of(value: Value) -> float | None:
    """The number of a value without its unit; ``None`` where it is a word."""
    if isinstance(value, str):
        try:
            return float(split_quantity(value)[0])
        except QuantityError:
            return None
    return float(value)


def is_word(value: Value) -> bool:
    """Whether a value is no number, with or without a unit, and not true or false."""
    return isinstance(value, str) and number_of(value) is None


def unit_of(value: Value) -> str:
    """The unit that a value is written with; empty without one."""
    if not isinstance(value, str):
        return ""
    try:
        return split_quantity(value)[1] or ""
    except QuantityError:
        return ""


def _quantity(name: str, value: Value) -> tuple[Fraction, str | None]:
    try:
        return split_quantity(str(value))
    except QuantityError as error:
        raise InputError(f"{name}: {error}") from None


def _listed(name: str, text: str) -> Sequence[str]:
    """Parts between commas that stand in no bracket."""
    parts: list[str] = []
    depth, part = 0, ""
    for character in text:
        depth += (character in "[{") - (character in "]}")
        if character == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += character
    found = [each.strip() for each in (*parts, part)]
    if not all(found):
        raise InputError(f"{name}: '{text}' has an empty value; write 1, 2, 5 or 0..39.")
    return found


def _plain(text: str) -> Value:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return {"true": True, "false": False}.get(text, text)
