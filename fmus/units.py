"""FMI unit strings made of SI units, and their exponents of the base units.

``N.s/m``, ``kg.m2``, ``rad/s``, ``N.m/A``, ``N/(m.s)``, ``1``. Every unit here is coherent: there
are no factors and no offsets.
"""

from __future__ import annotations

import re

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_SYMBOLS: dict[str, dict[str, int]] = {
    **{symbol: {symbol: 1} for symbol in BASE},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "C": {"A": 1, "s": 1},
    "Hz": {"s": -1},
}

_FACTOR = re.compile(r"([A-Za-z]+)(-?\d+)?")


def base_exponents(unit: str) -> dict[str, int]:
    """The exponents of the SI base units (and ``rad``), zeros left out.

    Raises:
        ValueError: the unit is not understood.
    """
    numerator, *denominators = unit.split("/")
    if len(denominators) > 1:
        raise ValueError(f"unit '{unit}' has two slashes; write a/(b.c).")
    exponents: dict[str, int] = {}
    _multiply(exponents, unit, numerator, 1)
    for denominator in denominators:
        _multiply(exponents, unit, denominator.removeprefix("(").removesuffix(")"), -1)
    return {base: exponents[base] for base in BASE if exponents.get(base)}


def _multiply(exponents: dict[str, int], unit: str, product: str, sign: int) -> None:
    for factor in product.split("."):
        if factor == "1":
            continue
        match = _FACTOR.fullmatch(factor)
        if match is None or match[1] not in _SYMBOLS:
            raise ValueError(f"unit '{unit}': '{factor}' is not an SI unit that is known here.")
        power = sign * int(match[2] or 1)
        for base, exponent in _SYMBOLS[match[1]].items():
            exponents[base] = exponents.get(base, 0) + power * exponent
