"""What becomes of each packet of a channel: its delay, or that it is lost, and whether it doubles.

The kernel only carries out what is drawn here. A fate depends on the seed, the channel, the
direction, the rate and the packet's number: never on the order of components, on the size of a
block, or on what other channels do.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cosim.base.counter import draws, stream_key, thresholds, top_bits
from cosim.scenario import Bernoulli, Direction, GilbertElliott

LOST = -1
NO_COPY = -1

_JITTER, _LOSS, _STATE, _REORDER, _DUPLICATION, _STATIONARY = range(6)


@dataclass(slots=True)
class Fates:
    """The stream of fates of one direction of a channel at one rate.

    Blocks must be asked for in order: the Gilbert-Elliott chain moves once a packet.
    """

    direction: Direction
    key: int
    _bad: bool | None = field(default=None, init=False)
    _next: int = field(default=0, init=False)

    @property
    def shortest(self) -> int:
        """The shortest delay that a packet of this stream can have (ticks)."""
        if self.direction.trace is not None:
            return min((delay for delay in self.direction.trace if delay != LOST), default=1)
        jitter = self.direction.jitter
        first = next(i for i, weight in enumerate(jitter.weights) if weight > 0)
        return self.direction.delay.ticks + first * jitter.step

    @property
    def longest(self) -> int:
        """The longest delay that a packet or its second copy can have (ticks)."""
        direction = self.direction
        if direction.trace is not None:
            longest = max(direction.trace)
        else:
            jitter = direction.jitter
            longest = direction.delay.ticks + (len(jitter.weights) - 1) * jitter.step
        if direction.reorder.probability > 0:
            longest += direction.reorder.ticks
        if direction.duplication.probability > 0:
            longest += direction.duplication.ticks
        return max(longest, 0)

    @property
    def is_constant(self) -> bool:
        """Whether every packet arrives, all with the same delay."""
        return self.direction.trace is None and not self.direction.is_random

    def take(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The delays (ticks, -1 lost) of the next packets and of their copies (-1 none)."""
        first, self._next = self._next, self._next + count
        direction = self.direction
        if direction.trace is not None:
            numbers = np.arange(first, first + count) % len(direction.trace)
            delays = np.array(direction.trace, dtype=np.int64)[numbers]
        else:
            delays = direction.delay.ticks + self._jitter(first, count)
            delays[self._losses(first, count)] = LOST
        arrives = delays != LOST
        held_back = self._happens(_REORDER, direction.reorder.probability, first, count)
        delays[arrives & held_back] += direction.reorder.ticks
        doubled = self._happens(_DUPLICATION, direction.duplication.probability, first, count)
        copies = np.where(arrives & doubled, delays + direction.duplication.ticks, NO_COPY)
        return delays, copies

    def _jitter(self, first: int, count: int) -> NDArray[np.int64]:
        jitter = self.direction.jitter
        if len(jitter.weights) == 1:
            return np.zeros(count, dtype=np.int64)
        below = thresholds(_running_sums(jitter.weights))
        drawn = top_bits(draws(self.key, _JITTER, first, count))
        index = np.searchsorted(below, drawn, side="right")
        return np.minimum(index, len(jitter.weights) - 1).astype(np.int64) * jitter.step

    def _losses(self, first: int, count: int) -> NDArray[np.bool_]:
        loss = self.direction.loss
        if isinstance(loss, Bernoulli):
            return self._happens(_LOSS, loss.probability, first, count)
        bad = self._chain(loss, first, count)
        lost_when_bad = self._happens(_LOSS, loss.loss_bad, first, count)
        lost_when_good = self._happens(_LOSS, loss.loss_good, first, count)
        return np.where(bad, lost_when_bad, lost_when_good)

    def _chain(self, loss: GilbertElliott, first: int, count: int) -> NDArray[np.bool_]:
        """Whether the chain is in its bad state at each packet; it moves after each packet."""
        if self._bad is None:
            total = loss.good_to_bad + loss.bad_to_good
            share = loss.good_to_bad / total if total > 0 else 0.0
            self._bad = bool(self._happens(_STATIONARY, share, 0, 1)[0])
        worsens = self._happens(_STATE, loss.good_to_bad, first, count).tolist()
        recovers = self._happens(_STATE, loss.bad_to_good, first, count).tolist()
        bad, states = self._bad, np.zeros(count, dtype=np.bool_)
        for i in range(count):
            states[i] = bad
            bad = not recovers[i] if bad else worsens[i]
        self._bad = bad
        return states

    def _happens(
        self, purpose: int, probability: float, first: int, count: int
    ) -> NDArray[np.bool_]:
        if probability <= 0:
            return np.zeros(count, dtype=np.bool_)
        limit = thresholds([probability])[0]
        return top_bits(draws(self.key, purpose, first, count)) < limit


def fates_of(seed: int, channel: str, way: str, rate: Fraction, direction: Direction) -> Fates:
    """The stream of one direction (``forward`` or ``backward``) of a channel at one rate (Hz)."""
    return Fates(direction=direction, key=stream_key(seed, channel, way, str(rate)))


def _running_sums(weights: tuple[float, ...]) -> list[float]:
    total, sums = 0.0, list[float]()
    for weight in weights:
        total += weight
        sums.append(total)
    return sums
