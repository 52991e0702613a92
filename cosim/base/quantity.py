"""Numbers with units: ``2.44 ms``, ``1024/3 Hz``, ``20 %``, ``0.4 N.s/m``; plain numbers are SI.

Values are exact fractions until something asks for a float. Units follow FMI's notation: ``.`` (or
``*``, ``·``) between factors, ``/`` before a divisor, an exponent right behind its unit
(``kg.m2``, ``m/s2``, ``s-1``).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction

from cosim.base.typography import comma_in_number, odd_characters
from cosim.base.unit_hint import unit_hint

Dimension = tuple[int, int, int, int, int]
"""Exponents of kg, m, s, A and rad."""

_NONE: Dimension = (0, 0, 0, 0, 0)
_TIME: Dimension = (0, 0, 1, 0, 0)
_FORCE: Dimension = (1, 1, -2, 0, 0)
_ENERGY: Dimension = (1, 2, -2, 0, 0)
_VOLTAGE: Dimension = (1, 2, -3, -1, 0)
_ANGLE: Dimension = (0, 0, 0, 0, 1)
_DEGREE = Fraction(math.pi) / 180

_PREFIXED: dict[str, tuple[Fraction, Dimension]] = {
    "m": (Fraction(1), (0, 1, 0, 0, 0)),
    "g": (Fraction(1, 1000), (1, 0, 0, 0, 0)),
    "s": (Fraction(1), _TIME),
    "A": (Fraction(1), (0, 0, 0, 1, 0)),
    "rad": (Fraction(1), _ANGLE),
    "Hz": (Fraction(1), (0, 0, -1, 0, 0)),
    "N": (Fraction(1), _FORCE),
    "J": (Fraction(1), _ENERGY),
    "W": (Fraction(1), (1, 2, -3, 0, 0)),
    "V": (Fraction(1), _VOLTAGE),
    "Ohm": (Fraction(1), (1, 2, -3, -2, 0)),
    "Pa": (Fraction(1), (1, -1, -2, 0, 0)),
}
_WHOLE: dict[str, tuple[Fraction, Dimension]] = {
    "1": (Fraction(1), _NONE),
    "%": (Fraction(1, 100), _NONE),
    "min": (Fraction(60), _TIME),
    "h": (Fraction(3600), _TIME),
    "deg": (_DEGREE, _ANGLE),
    "rev": (360 * _DEGREE, _ANGLE),
    "rpm": (6 * _DEGREE, (0, 0, -1, 0, 1)),
}
_PREFIXES = {
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "µ": Fraction(1, 10**6),
    "μ": Fraction(1, 10**6),
    "m": Fraction(1, 10**3),
    "c": Fraction(1, 100),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
_NUMBER = re.compile(
    r"\s*(?P<number>[+-]?(?:\d{1,40}(?:\.\d{0,40})?|\.\d{1,40})(?:[eE][+-]?\d{1,3})?)"
    r"(?:\s*/\s*(?P<divisor>\d{1,40}))?\s*(?P<unit>[^\W\d_].*?|[%°].*?)?\s*",
    re.DOTALL,
)
_COMMA = re.compile(r"\s*[+-]?\d+(,\d+)+(\.\d+)?(?![,\d])")
_FACTOR = re.compile(r"(?P<symbol>1|%|[A-Za-zµμ]+)(?P<exponent>\^?[+-]?\d{1,2}|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
_SUPERSCRIPT = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class QuantityError(ValueError):
    """The text is no number with a unit, or its unit is of another dimension; says so."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as its SI factor and its dimension."""

    factor: Fraction
    dimension: Dimension


def parse_unit(text: str) -> Unit:
    """Read a unit such as ``N.s/m``.

    Raises:
        QuantityError: a unit symbol is not known.
    """
    factor, exponents, position, sign = Fraction(1), list(_NONE), 0, 1
    while True:
        match = _FACTOR.match(text, position)
        known = match and _symbol(match["symbol"])
        if not match or not known:
            raise _unknown_unit(text)
        power = sign * int((match["exponent"] or "1").lstrip("^").translate(_SUPERSCRIPT))
        factor *= known[0] ** power
        exponents = [a + power * b for a, b in zip(exponents, known[1], strict=True)]
        position = match.end()
        if position == len(text):
            mass, length, time, current, angle = exponents
            return Unit(factor, (mass, length, time, current, angle))
        if text[position] not in ".*·/":
            raise _unknown_unit(text)
        sign = -1 if text[position] == "/" else 1
        position += 1


def split_quantity(text: str) -> tuple[Fraction, str | None]:
    """The number of a quantity and the text of its unit, ``None`` without one.

    Raises:
        QuantityError: the text does not begin with a number.
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
    return number, match["unit"]


def exact(number: float) -> Fraction:
    """The fraction that a number was written as: ``0.1`` is 1/10, not the nearest double.

    Raises:
        QuantityError: the number is infinite or not a number.
    """
    if isinstance(number, int):
        return Fraction(number)
    if not math.isfinite(number):
        raise QuantityError(f"{number} is not a finite number.")
    return Fraction(repr(number))


def quantity(value: float | str, unit: str) -> Fraction:
    """A value in ``unit``: a plain number is in ``unit`` already, a text is converted to it.

    Raises:
        QuantityError: no number, or a unit of another dimension.
    """
    if not isinstance(value, str):
        return exact(value)
    number, written = split_quantity(value)
    if written is None:
        return number
    given, wanted = parse_unit(written), parse_unit(unit)
    if given.dimension != wanted.dimension:
        raise QuantityError(f"'{value}' is in {written}, which does not convert to {unit}.")
    return number * given.factor / wanted.factor


def format_exact(value: Fraction) -> str:
    """A fraction as a decimal where that is exact and short, else as ``a/b``."""
    if value.denominator == 1:
        return str(value.numerator)
    decimal = repr(float(value)) if abs(value) < 10**300 else ""
    return decimal if decimal and Fraction(decimal) == value else f"{value}"


def _unknown_unit(text: str) -> QuantityError:
    return QuantityError(f"'{text}' is not a unit known here.{unit_hint(text, _is_unit)}")


def _is_unit(text: str) -> bool:
    position = 0
    while match := _FACTOR.match(text, position):
        position = match.end() + 1
        if not _symbol(match["symbol"]) or text[match.end() : position] not in {*".*·/", ""}:
            return False
    return position == len(text) + 1


def _symbol(symbol: str) -> tuple[Fraction, Dimension] | None:
    if symbol in _WHOLE:
        return _WHOLE[symbol]
    if symbol in _PREFIXED:
        return _PREFIXED[symbol]
    prefix, base = _PREFIXES.get(symbol[0]), _PREFIXED.get(symbol[1:])
    return (prefix * base[0], base[1]) if prefix is not None and base is not None else None
