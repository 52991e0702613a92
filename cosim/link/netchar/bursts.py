"""Losses in a row: counted as they come, and fitted by a channel with a good and a bad state."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FEW = 10
"""Losses, or packets that came, below which nothing is fitted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstyLoss:
    """A Gilbert–Elliott channel: probabilities per packet, good state without loss."""

    good_to_bad: float
    bad_to_good: float
    loss_bad: float


@dataclass(slots=True)
class LossPattern:
    """What a sequence of losses of any length comes to, in the memory of its kinds of bursts."""

    count: int = 0
    losses: int = 0
    pairs: int = 0
    """Both of two neighbours lost."""
    ends: int = 0
    """First and last of three lost."""
    triples: int = 0
    """All three of three lost."""
    _bursts: Counter[int] = field(default_factory=Counter[int])
    _last: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """The last two packets, whose neighbours are still to come."""
    _open: int = 0
    """Losses in a row up to the last packet."""

    def add(self, lost: NDArray[np.bool_]) -> None:
        """Go on with the next packets; ``lost`` has shape (packets,)."""
        joined = np.concatenate((self._last, lost))
        both = joined[:-1] & joined[1:]
        # The pair of the last two was counted when they came.
        self.pairs += int(np.sum(both[max(0, len(self._last) - 1) :]))
        ends = joined[:-2] & joined[2:]
        self.ends += int(np.sum(ends))
        self.triples += int(np.sum(ends & joined[1:-1]))
        self.count += len(lost)
        self.losses += int(lost.sum())
        self._last = joined[-2:].copy()
        self._count_bursts(lost)

    def _count_bursts(self, lost: NDArray[np.bool_]) -> None:
        edges = np.flatnonzero(np.diff(np.concatenate(([0], lost.view(np.int8), [0]))))
        starts, ends = edges[::2], edges[1::2]
        lengths = ends - starts
        if self._open and not (len(starts) and starts[0] == 0) and len(lost):
            self._bursts[self._open] += 1
            self._open = 0
        if len(lengths) and starts[0] == 0:
            lengths[0] += self._open
            self._open = 0
        if len(lengths) and ends[-1] == len(lost):
            self._open = int(lengths[-1])
            lengths = lengths[:-1]
        for length, times in zip(*np.unique(lengths, return_counts=True), strict=True):
            self._bursts[int(length)] += int(times)

    @property
    def bursts(self) -> dict[int, int]:
        """Length in packets -> how often, the shortest first."""
        found = self._bursts.copy()
        if self._open:
            found[self._open] += 1
        return dict(sorted(found.items()))


def fit_bursts(pattern: LossPattern) -> BurstyLoss | None:
    """Gilbert's model fitted to a sequence of losses, or ``None`` where they look independent.

    Source: Gilbert (1960), "Capacity of a burst-noise channel", from P(1), P(1|1) and
    P(111) / (P(101) + P(111)); where those give no probabilities, the two-state chain that loses
    everything in its bad state, whose estimates are counts of transitions.
    """
    count, losses = pattern.count, pattern.losses
    if losses < FEW or losses > count - FEW:
        return None
    overall = losses / count
    after_loss = pattern.pairs / losses
    # Independent draws would give ``overall``; three standard errors more is a burst.
    if after_loss - overall < 3.0 * np.sqrt(overall * (1.0 - overall) / losses):
        return None
    simple = BurstyLoss(
        good_to_bad=(losses - pattern.pairs) / (count - losses),
        bad_to_good=1.0 - after_loss,
        loss_bad=1.0,
    )
    if pattern.ends < 30:
        return simple
    a, b, c = overall, after_loss, pattern.triples / pattern.ends
    below = 2.0 * a * c - b * (a + c)
    stay = (a * c - b * b) / below if below else 0.0
    if not b < stay < 1.0:
        return simple
    loss_bad = b / stay
    bad_to_good = 1.0 - stay
    good_to_bad = a * bad_to_good / (loss_bad - a) if loss_bad > a else 0.0
    if not (0.0 < good_to_bad < 1.0 and loss_bad < 1.0):
        return simple
    return BurstyLoss(good_to_bad=good_to_bad, bad_to_good=bad_to_good, loss_bad=loss_bad)
