"""Numbers and tables as people read them: handy units, and no wider than the terminal."""

from __future__ import annotations

import math
from textwrap import wrap

_HANDY = {"1": (100.0, "%"), "m": (1e3, "mm"), "rad": (180 / math.pi, "°"), "m/s": (1e3, "mm/s")}


def human(value: float | None, unit: str) -> str:
    """A value with its unit; lengths in mm and angles in degrees."""
    if value is None or math.isnan(value):
        return "–"
    factor, name = _HANDY.get(unit, (1.0, unit))
    space = "" if name in {"", "°"} else " "
    return f"{value * factor:.3g}{space}{name}"


def table(rows: list[tuple[str, ...]], *, indent: str = "  ", width: int | None = None) -> str:
    """Rows of text in columns: the first and second to the left, the others to the right.

    The first row is the heading. Where that is wider than ``width``, each row becomes its first
    cell and, below it, the others with their headings.
    """
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    if width is not None and len(indent) + sum(widths) + 2 * len(widths) - 2 > width:
        return "\n".join(_stacked(rows, indent, width))
    lines: list[str] = []
    for row in rows:
        cells = [
            text.ljust(width) if column < 2 else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append(f"{indent}{'  '.join(cells)}".rstrip())
    return "\n".join(lines)


def _stacked(rows: list[tuple[str, ...]], indent: str, width: int) -> list[str]:
    heading, *others = rows
    lines: list[str] = []
    for name, *cells in others:
        pairs = [f"{head} {cell}" for head, cell in zip(heading[1:], cells, strict=True) if cell]
        lines += [indent + name, *_filled(pairs, f"{indent}  ", width)]
    return lines


def _filled(parts: list[str], indent: str, width: int) -> list[str]:
    """Parts joined by a dot, each whole on one line."""
    lines: list[str] = []
    for part in parts:
        if lines and len(lines[-1]) + 3 + len(part) <= width:
            lines[-1] += f" · {part}"
        else:
            lines.append(indent + part)
    return lines


def fitted(text: str, width: int | None) -> str:
    """The text with its long lines wrapped, and what goes on indented by two more columns."""
    if width is None:
        return text
    return "\n".join(part for line in text.splitlines() for part in _wrapped(line, width))


def _wrapped(line: str, width: int) -> list[str]:
    if len(line) <= width:
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return wrap(line.strip(), width, initial_indent=indent, subsequent_indent=f"{indent}  ")
