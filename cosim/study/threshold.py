"""The value that is noticed in half of the trials, with an interval, from yes-or-no answers.

A logistic psychometric function 1 / (1 + exp(−s (x − t))); the posterior of threshold t and slope s
on a grid, flat in t over the values that could be shown and in log s, as in Kuss, Jäkel and
Wichmann 2005. The interval holds the middle 95 % of t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

POINTS = 401
SLOPES = 61


@dataclass(frozen=True, slots=True)
class Threshold:
    """Median and 95 % interval, in the unit of the values."""

    value: float
    low: float
    high: float
    trials: int


def estimate(past: Sequence[tuple[float, bool]], least: float, most: float) -> Threshold:
    """The threshold that answers speak for.

    Args:
        past: value and whether it was noticed.
        least: the smallest value that could be shown; the threshold is sought from there
        most: to here.
    """
    thresholds = np.linspace(least, most, POINTS)
    slopes = np.geomspace(0.5, 500.0, SLOPES) / (most - least)
    log = np.zeros((SLOPES, POINTS))
    for value, was_noticed in past:
        steep = slopes[:, None] * (value - thresholds[None, :])
        log -= np.logaddexp(0.0, -steep if was_noticed else steep)
    posterior = np.exp(log - log.max()).sum(axis=0)
    share = np.cumsum(posterior) / posterior.sum()
    low, middle, high = (float(np.interp(p, share, thresholds)) for p in (0.025, 0.5, 0.975))
    return Threshold(middle, low, high, len(past))
