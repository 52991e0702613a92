"""Which unit a misspelt one means: ``sec``, ``mS``, ``KHz``, ``Nm``, ``kg m2``."""

from __future__ import annotations

import re
from collections.abc import Callable

_WORDS = {
    "s": "sec secs second seconds",
    "ms": "msec msecs millisec milliseconds millisecond",
    "us": "usec microseconds microsecond",
    "min": "mins minute minutes",
    "h": "hr hrs hour hours",
    "Hz": "hertz cps",
    "m": "meter meters metre metres",
    "mm": "millimeter millimeters millimetre millimetres",
    "g": "gram grams",
    "kg": "kilo kilos kilogram kilograms",
    "N": "newton newtons",
    "V": "volt volts",
    "A": "amp amps ampere amperes",
    "Ohm": "ohms Ω",
    "deg": "degree degrees °",
    "rad": "radian radians",
    "%": "percent pct",
}
_SPELT = {word: unit for unit, words in _WORDS.items() for word in words.split()}
_SYMBOL = re.compile(r"[^\W\d_]+|[°Ω%]")


def unit_hint(text: str, is_unit: Callable[[str], bool]) -> str:
    """A sentence with the unit that is meant, or empty; ``is_unit`` says what is one.

    Begins with a space.
    """
    spelt = _SYMBOL.sub(lambda symbol: _symbol(symbol.group(), is_unit), text.strip(" ,;"))
    joined = re.sub(r"\s*([./*·])\s*|\s+", lambda gap: gap.group(1) or ".", spelt)
    return f" Did you mean {joined}?" if joined != text and is_unit(joined) else ""


def _symbol(symbol: str, is_unit: Callable[[str], bool]) -> str:
    """One symbol of a unit in its right spelling, with dots between glued ones."""
    if is_unit(symbol):
        return symbol
    if symbol.casefold() in _SPELT:
        return _SPELT[symbol.casefold()]
    if symbol[0] == "K" and is_unit(f"k{symbol[1:]}"):
        return f"k{symbol[1:]}"  # kilo is seldom kelvin
    halves = ((symbol[:end], symbol[end:]) for end in range(len(symbol) - 1, 0, -1))
    glued = next((pair for pair in halves if all(map(is_unit, pair))), None)
    if glued:
        return ".".join(glued)
    for other in _cases(symbol):
        if is_unit(other):
            return other
    for end in range(len(symbol) - 1, 0, -1):
        if is_unit(symbol[:end]):
            rest = _symbol(symbol[end:], is_unit)
            if is_unit(rest):
                return f"{symbol[:end]}.{rest}"
    return symbol


def _cases(symbol: str) -> list[str]:
    """Other ways to write it large and small; the prefix keeps its own where it can."""
    first, rest = symbol[0], symbol[1:]
    tails = [rest, rest.lower(), rest.capitalize(), rest.upper()]
    heads = [first, first.lower(), first.upper()]
    return [head + tail for head in heads for tail in tails]
