"""Numbers as people read them: SI inside, the handy unit in a text."""

from __future__ import annotations

import math

_HANDY = {"1": (100.0, "%"), "m": (1e3, "mm"), "rad": (180 / math.pi, "°"), "m/s": (1e3, "mm/s")}


def human(value: float | None, unit: str) -> str:
    """A value with its unit; lengths in mm and angles in degrees."""
    if value is None or math.isnan(value):
        return "–"
    factor, name = _HANDY.get(unit, (1.0, unit))
    space = "" if name in {"", "°"} else " "
    return f"{value * factor:.3g}{space}{name}"


def table(rows: list[tuple[str, ...]], *, indent: str = "  ") -> str:
    """Rows of text in columns: the first and second to the left, the others to the right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines: list[str] = []
    for row in rows:
        cells = [
            text.ljust(width) if column < 2 else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append(f"{indent}{'  '.join(cells)}".rstrip())
    return "\n".join(lines)
