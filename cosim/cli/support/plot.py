"""A signal as a few lines of text, for a terminal."""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite

WIDTH, HEIGHT = 60, 4
_BLOCKS = " ▁▂▃▄▅▆▇█"


def plot(name: str, unit: str, values: Collection[float]) -> list[str]:
    """A title with the newest value and the range, then ``HEIGHT`` lines of bars.

    Each of the ``WIDTH`` bars is the value farthest from the range's middle among those that it
    stands for, so that a peak of a single tick is seen.
    """
    known = [value for value in values if isfinite(value)]
    if not known:
        return [f"{name}: nothing yet"]
    low, high = min(known), max(known)
    title = f"{name} = {known[-1]:.4g} {unit}  [{low:.4g}, {high:.4g}]"
    span = (high - low) or 1.0
    middle = (low + high) / 2
    columns = min(WIDTH, len(known))
    bars: list[int] = []
    for column in range(columns):
        part = known[column * len(known) // columns : (column + 1) * len(known) // columns]
        value = max(part, key=lambda each: abs(each - middle))
        bars.append(1 + round((value - low) / span * (8 * HEIGHT - 1)))
    lines = [
        "".join(_BLOCKS[min(8, max(0, bar - 8 * row))] for bar in bars)
        for row in reversed(range(HEIGHT))
    ]
    return [title, *lines]
