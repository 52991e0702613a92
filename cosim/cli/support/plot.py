"""A signal as a few lines of text, for a terminal."""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite

WIDTH, HEIGHT = 60, 4
_BLOCKS = " ▁▂▃▄▅▆▇█"


def plot(name: str, unit: str, values: Collection[float], width: int = WIDTH) -> list[str]:
    """A title with the newest value and the range, then ``HEIGHT`` lines of bars.

    No line is longer than ``width``: the range takes a line of its own, and a name loses its
    beginning, where they do not fit. Each of the up to ``width`` bars is the value farthest from
    the range's middle among those that it stands for, so that a peak of a single tick is seen.
    """
    known = [value for value in values if isfinite(value)]
    if not known:
        return [_shortened(name, ": nothing yet", width)]
    low, high = min(known), max(known)
    newest, extent = f" = {known[-1]:.4g} {unit}".rstrip(), f"[{low:.4g}, {high:.4g}]"
    titles = [f"{name}{newest}  {extent}"]
    if len(titles[0]) > width:
        titles = [_shortened(name, newest, width), extent]
    span = (high - low) or 1.0
    middle = (low + high) / 2
    columns = min(width, len(known))
    bars: list[int] = []
    for column in range(columns):
        part = known[column * len(known) // columns : (column + 1) * len(known) // columns]
        value = max(part, key=lambda each: abs(each - middle))
        bars.append(1 + round((value - low) / span * (8 * HEIGHT - 1)))
    lines = [
        "".join(_BLOCKS[min(8, max(0, bar - 8 * row))] for bar in bars)
        for row in reversed(range(HEIGHT))
    ]
    return [*titles, *lines]


def _shortened(name: str, rest: str, width: int) -> str:
    """Name and rest on one line; what a name begins with is missed least."""
    over = len(name) + len(rest) - width
    return (name if over <= 0 else f"…{name[over + 1 :]}") + rest
