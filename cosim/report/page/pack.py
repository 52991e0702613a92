"""Signals small enough for a page: sixteen bits, differences, bytes apart, deflated.

Differences of neighbours are small, and their high bytes nearly all equal, so that deflate finds
what repeats. ``report.js`` takes the same steps back.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEVELS = 65534
"""Steps from the least to the greatest value; one more number stands for NaN."""
NAN = 65535


def pack(values: NDArray[Any]) -> dict[str, Any]:
    """A signal as JSON: ``low``, ``step`` and the packed numbers of steps; see ``unpack``.

    Whole numbers stay exact where they span at most ``LEVELS``; others are off by at most half a
    step. Infinite values are the ends of what is finite.

    Args:
        values: shape (rows,).
    """
    numbers = values.astype(np.float64)
    known = np.isfinite(numbers)
    low, high = _ends(numbers[known])
    step = 1.0 if values.dtype.kind in "iu" and high - low <= LEVELS else (high - low) / LEVELS
    packed: dict[str, Any] = {"rows": int(numbers.size), "low": low, "step": step}
    if step == 0.0 and known.all():
        return packed  # one value throughout
    clipped = np.clip(numbers, low, high)
    steps = np.full(numbers.size, NAN, np.uint16)
    there = ~np.isnan(numbers)
    steps[there] = np.rint((clipped[there] - low) / (step or 1.0)).astype(np.uint16)
    differences = np.diff(steps, prepend=np.uint16(0))
    planes = differences.astype("<u2").view(np.uint8).reshape(-1, 2).T
    deflate = zlib.compressobj(6, zlib.DEFLATED, -zlib.MAX_WBITS)
    content = deflate.compress(planes.tobytes()) + deflate.flush()
    return packed | {"data": base64.b64encode(content).decode("ascii")}


def unpack(packed: dict[str, Any]) -> NDArray[np.float64]:
    """The values again, shape (rows,): what the page shows."""
    if "data" not in packed:
        return np.full(int(packed["rows"]), float(packed["low"]))
    content = zlib.decompress(base64.b64decode(packed["data"]), -zlib.MAX_WBITS)
    planes = np.frombuffer(content, np.uint8).reshape(2, -1)
    differences = np.ascontiguousarray(planes.T).view("<u2")[:, 0]
    steps: NDArray[np.uint16] = np.cumsum(differences, dtype=np.uint16)
    values: NDArray[np.float64] = packed["low"] + packed["step"] * steps.astype(np.float64)
    values[steps == NAN] = np.nan
    return values


def _ends(known: NDArray[np.float64]) -> tuple[float, float]:
    if not known.size:
        return 0.0, 0.0
    return max(-LARGEST, float(known.min())), min(LARGEST, float(known.max()))


LARGEST = 8e307
"""Of a run that ran away; the range between two such ends is still a number."""
