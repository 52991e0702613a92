"""Units: what two of them have in common, from FMI unit definitions or from their SI spelling."""

from __future__ import annotations

import re
from dataclasses import dataclass

_BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_SI: dict[str, dict[str, int]] = {
    **{base: {base: 1} for base in _BASES},
    "1": {},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "C": {"A": 1, "s": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "T": {"kg": 1, "s": -2, "A": -1},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {"s": -1},
}
_SCALED: dict[str, tuple[str, float]] = {
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "km": ("m", 1e3),
    "g": ("kg", 1e-3),
    "ms": ("s", 1e-3),
    "min": ("s", 60.0),
    "h": ("s", 3600.0),
    "deg": ("rad", 0.017453292519943295),
    "mN": ("N", 1e-3),
    "kN": ("N", 1e3),
    "mA": ("A", 1e-3),
    "mV": ("V", 1e-3),
}
_FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^?(-?\d+))?")


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as FMI defines it: ``base value = factor * value + offset`` (FMI 3.0, 2.4.3).

    ``exponents`` follow kg, m, s, A, K, mol, cd, rad; ``None`` where the unit is only a name.
    """

    name: str
    exponents: tuple[int, ...] | None
    factor: float = 1.0
    offset: float = 0.0


def parse_unit(name: str) -> Unit:
    """A unit from its spelling (``N.m``, ``N.s/m``, ``mm``); an unknown word stays a name."""
    total: dict[str, int] = dict.fromkeys(_BASES, 0)
    factor = 1.0
    for position, part in enumerate(name.replace("*", ".").split("/")):
        sign = 1 if position == 0 else -1
        for word in part.strip("() ").split("."):
            match = _FACTOR.fullmatch(word)
            if match is None:
                return Unit(name, None)
            symbol, power = match.group(1), sign * int(match.group(2) or 1)
            if symbol in _SCALED:
                symbol, scale = _SCALED[symbol]
                factor *= scale**power
            if symbol not in _SI:
                return Unit(name, None)
            for base, exponent in _SI[symbol].items():
                total[base] += power * exponent
    return Unit(name, tuple(total.values()), factor)


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
    if source.factor == target.factor and source.offset == target.offset:
        return (1.0, 0.0)
    return (source.factor / target.factor, (source.offset - target.offset) / target.factor)
