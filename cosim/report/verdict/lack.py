"""What keeps something from being measured, as the beginning of a sentence."""

from __future__ import annotations

import numpy as np

from cosim.record.reader import Run
from cosim.report.target import Target, blocks


def lack_of(run: Run, target: Target, first: int, last: int, samples: int = 1) -> str:
    """What keeps a target from being measured over ``first`` <= tick < ``last``, or nothing."""
    rows = 0
    for ticks, values in blocks(run, target, first, last):
        wrong = ~np.isfinite(values)
        if wrong.any():
            row = int(np.argmax(wrong))
            when = float(run.seconds(ticks[row : row + 1])[0])
            return f"no finite number: {target.text} is {values[row]} at t = {when:g} s"
        rows += ticks.size
    return "" if rows >= samples else f"nothing in this window: {too_few(target, rows, samples)}"


def too_few(target: Target, rows: int, samples: int) -> str:
    """That a window holds so few rows of a target, of those that are needed."""
    have = {0: "no sample", 1: "one sample"}.get(rows, f"{rows} samples")
    return f"{have} of {target.text}" + (f", and it takes {samples}" if samples > 1 else "")
