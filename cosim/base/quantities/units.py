"""Units: one table with exact factors, and one reader of their spelling.

Spelling follows FMI and Modelica: ``.`` (or ``*``, ``·``) between factors, one ``/`` before a
divisor, parentheses around a divisor of several factors, an exponent right behind its unit
(``kg.m2``, ``m/s2``, ``N/(m.s)``, ``s-1``). Uses the standard library alone, since the build hook
reads units before anything is installed.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units, in the order of every unit's exponents."""

Exponents = tuple[int, ...]

_ONE: Exponents = (0,) * len(BASES)
_DEGREE = Fraction(math.pi) / 180

_DERIVED: dict[str, dict[str, int]] = {
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "C": {"A": 1, "s": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
}
_SCALED: dict[str, tuple[Fraction, dict[str, int]]] = {
    "1": (Fraction(1), {}),
    "%": (Fraction(1, 100), {}),
    "min": (Fraction(60), {"s": 1}),
    "h": (Fraction(3600), {"s": 1}),
    "deg": (_DEGREE, {"rad": 1}),
    "rev": (360 * _DEGREE, {"rad": 1}),
    "rpm": (6 * _DEGREE, {"rad": 1, "s": -1}),
}
_SHIFTED: dict[str, tuple[Fraction, Fraction]] = {
    "degC": (Fraction(1), Fraction(27315, 100)),
    "degF": (Fraction(5, 9), Fraction(45967, 180)),
}
"""Temperatures with another zero: factor and offset to K. They stand alone, in no product."""
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
_FACTOR = re.compile(r"(?P<symbol>1|%|[A-Za-zµμ]+)(?P<exponent>\^?[+-]?\d{1,2}|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
_SUPERSCRIPT = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class UnitError(ValueError):
    """A spelling that is no unit known here; says so."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as FMI defines it: ``base value = factor * value + offset`` (FMI 3.0, 2.4.3).

    ``exponents`` follow :data:`BASES`; ``None`` where the unit is only a name.
    """

    name: str
    exponents: Exponents | None
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)

    @property
    def is_coherent(self) -> bool:
        """Whether a value in this unit is the value in base units."""
        return self.exponents is not None and (self.factor, self.offset) == (1, 0)


def _table() -> dict[str, tuple[Fraction, Exponents]]:
    """Every symbol that takes a prefix, with its factor; the kilogram is a gram with one."""
    whole = {base: {base: 1} for base in BASES if base != "kg"} | _DERIVED
    plain = {symbol: (Fraction(1), _exponents(powers)) for symbol, powers in whole.items()}
    return plain | {"g": (Fraction(1, 1000), _exponents({"kg": 1}))}


def _exponents(powers: dict[str, int]) -> Exponents:
    return tuple(powers.get(base, 0) for base in BASES)


_PREFIXED = _table()
_WHOLE = {symbol: (factor, _exponents(powers)) for symbol, (factor, powers) in _SCALED.items()}


def symbols() -> list[str]:
    """Every symbol that is known, those with a prefix included."""
    prefixed = [prefix + symbol for prefix in _PREFIXES for symbol in _PREFIXED]
    return list(dict.fromkeys([*_WHOLE, *_SHIFTED, *_PREFIXED, *prefixed]))


def parse_unit(text: str) -> Unit:
    """Read a unit such as ``N.s/m``.

    Raises:
        UnitError: a symbol is not known, or it is not clear what is divided by what.
    """
    if text in _SHIFTED:
        factor, offset = _SHIFTED[text]
        return Unit(text, _exponents({"K": 1}), factor, offset)
    numerator, *divisors = text.split("/")
    factor, exponents = _product(text, numerator, 1)
    for divisor in divisors:
        is_enclosed = divisor.startswith("(") and divisor.endswith(")")
        if not is_enclosed and any(separator in divisor for separator in ".*·"):
            raise UnitError(f"the unit '{text}' can be read in two ways; write a/(b.c) or a.c/b.")
        scale, powers = _product(text, divisor[1:-1] if is_enclosed else divisor, -1)
        factor *= scale
        exponents = tuple(a + b for a, b in zip(exponents, powers, strict=True))
    return Unit(text, exponents, factor)


def unit_of(name: str) -> Unit:
    """The unit of that spelling; an unknown word stays a name, which is equal to itself only."""
    try:
        return parse_unit(name)
    except UnitError:
        return Unit(name, None)


def conversion(source: Unit | None, target: Unit | None) -> tuple[float, float] | None:
    """Gain and offset that turn a value of ``source`` into one of ``target``.

    A side without a unit is not checked. ``None``: the two measure different things.
    """
    if source is None or target is None or source == target:
        return (1.0, 0.0)
    if source.exponents is None or target.exponents is None:
        return (1.0, 0.0) if source.name == target.name else None
    if source.exponents != target.exponents:
        return None
    gain = source.factor / target.factor
    return (float(gain), float((source.offset - target.offset) / target.factor))


def _product(text: str, product: str, sign: int) -> tuple[Fraction, Exponents]:
    factor, exponents = Fraction(1), _ONE
    for word in re.split("[.*·]", product):
        match = _FACTOR.fullmatch(word)
        known = match and _symbol(match["symbol"])
        if not match or not known:
            raise UnitError(f"'{text}' is not a unit known here.")
        power = sign * int((match["exponent"] or "1").lstrip("^").translate(_SUPERSCRIPT))
        factor *= known[0] ** power
        exponents = tuple(a + power * b for a, b in zip(exponents, known[1], strict=True))
    return factor, exponents


def _symbol(symbol: str) -> tuple[Fraction, Exponents] | None:
    found = _WHOLE.get(symbol) or _PREFIXED.get(symbol)
    if found is not None:
        return found
    prefix, base = _PREFIXES.get(symbol[0]), _PREFIXED.get(symbol[1:])
    return (prefix * base[0], base[1]) if prefix is not None and base is not None else None
