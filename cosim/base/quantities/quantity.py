"""Numbers with units: ``2.44 ms``, ``1024/3 Hz``, ``20 %``, ``0.4 N.s/m``; plain numbers are SI.

Values are exact fractions until something asks for a float. ``cosim.base.quantities.units`` says
how units are written.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from cosim.base.document.show import show
from cosim.base.document.typography import comma_in_number, odd_characters
from cosim.base.quantities.unit_hint import unit_hint
from cosim.base.quantities.units import Unit, UnitError, parse_unit, unit_of

_NUMBER = re.compile(
    r"\s*(?P<number>[+-]?(?:\d{1,40}(?:\.\d{0,40})?|\.\d{1,40})(?:[eE][+-]?\d{1,3})?)"
    r"(?:\s*/\s*(?P<divisor>\d{1,40}))?\s*(?P<unit>[^\W\d_].*?|[%°].*?)?\s*",
    re.DOTALL,
)
_PLAIN = re.compile(
    r"\s*[+-]?(?:\d{1,400}(?:\.\d{0,400})?|\.\d{1,400})(?:[eE][+-]?\d{1,3})?\s*", re.A
)
_COMMA = re.compile(r"\s*[+-]?\d+(,\d+)+(\.\d+)?(?![,\d])")


class QuantityError(ValueError):
    """The text is no number with a unit, or its unit is of another dimension; says so."""


def split_quantity(text: str) -> tuple[Fraction, str | None]:
    """The number of a quantity and the text of its unit, ``None`` without one.

    Raises:
        QuantityError: the text does not begin with a number, or with one that no 64 bits hold.
    """
    match = _NUMBER.fullmatch(text)
    if not match:
        comma = _COMMA.match(text)
        if comma:
            raise QuantityError(comma_in_number(comma.group().strip()))
        raise QuantityError(f"'{text}' is not a number with a unit.{odd_characters(text)}")
    number = Fraction(match["number"])
    if match["divisor"]:
        if int(match["divisor"]) == 0:
            raise QuantityError(f"'{text}' divides by zero.")
        number /= int(match["divisor"])
    return _held(number, text), match["unit"]


def decimal(text: str) -> Fraction:
    """A number of somebody else's file, exactly; one that a double can be, or nearly 0.

    Raises:
        QuantityError: it is none.
    """
    if not _PLAIN.fullmatch(text):
        raise QuantityError(f"'{text[:40]}' is not a number.{odd_characters(text[:40])}")
    found = Fraction(text)
    if abs(found) > sys.float_info.max:
        raise QuantityError(f"'{text[:40]}' is beyond every number that is computed with.")
    return found


def exact(number: float) -> Fraction:
    """The fraction that a number was written as: ``0.1`` is 1/10, not the nearest double.

    Raises:
        QuantityError: the number is infinite, not a number, or one that no 64 bits hold.
    """
    if isinstance(number, int):
        return _held(Fraction(number), number)
    if not math.isfinite(number):
        raise QuantityError(f"{show(number)} is not a finite number.")
    return Fraction(repr(number))


def _held(number: Fraction, written: float | str) -> Fraction:
    """The number, which a float can be close to.

    Raises:
        QuantityError: it is too large, or so small that a float would be 0.
    """
    try:
        is_held = (float(number) == 0.0) is (number == 0)
    except OverflowError:
        is_held = False
    if not is_held:
        size = "large" if abs(number) > 1 else "small"
        what = "a whole number of so many digits" if isinstance(written, int) else show(written)
        raise QuantityError(f"{what} is too {size} for a number of 64 bits.")
    return number


def simple(exact: Fraction) -> Fraction:
    """0.3333333333 was written for 1/3; an exact value stays what it is."""
    near = exact.limit_denominator(1_000_000)
    return near if abs(near - exact) <= abs(exact) * Fraction(1, 10**9) else exact


def quantity(
    value: float | str,
    unit: str | Unit,
    *,
    own: Mapping[str, Unit] = MappingProxyType({}),
    difference: bool = False,
) -> Fraction:
    """A value in ``unit``: a plain number is in ``unit`` already, a text is converted to it.

    ``own`` holds units that are defined beside those known here, by name, and come first.
    A ``difference`` has no offset, whatever unit it is written in.

    Raises:
        QuantityError: no number, one that no 64 bits hold, or a unit of another dimension.
    """
    if not isinstance(value, str):
        return exact(value)
    return _held(_converted(value, unit, own, difference), value)


def _converted(value: str, unit: str | Unit, own: Mapping[str, Unit], difference: bool) -> Fraction:
    number, spelling = split_quantity(value)
    if spelling is None:
        return number
    if spelling == (unit.name if isinstance(unit, Unit) else unit):
        return number
    wanted = unit if isinstance(unit, Unit) else _unit(unit)
    given = own.get(spelling) or _unit(spelling)
    if difference:
        wanted, given = (replace(each, offset=Fraction(0)) for each in (wanted, given))
    if given == wanted:
        return number
    if given.exponents is None or given.exponents != wanted.exponents:
        raise QuantityError(f"'{value}' is in {spelling}, which does not convert to {wanted.name}.")
    return (number * given.factor + given.offset - wanted.offset) / wanted.factor


def _unit(text: str) -> Unit:
    try:
        return parse_unit(text)
    except UnitError as error:
        raise QuantityError(f"{error}{unit_hint(text, _is_unit)}") from None


def _is_unit(text: str) -> bool:
    return unit_of(text).exponents is not None


def format_exact(value: Fraction) -> str:
    """A fraction as a decimal where that is exact and short, else as ``a/b``."""
    if value.denominator == 1:
        return str(value.numerator)
    short = repr(float(value)) if abs(value) < 10**300 else ""
    return short if short and Fraction(short) == value else f"{value}"
