"""What a bad network does to datagrams, drawn from a seed: the core of the UDP proxy and of tests.

It stands between two programs that speak the real protocol; the impairments of a *simulated*
channel are drawn by the master instead.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field

_JITTER_BOUND = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BadNetwork:
    """One direction; times in seconds, the rest are probabilities per datagram.

    ``jitter`` is the standard deviation of a normal distribution around ``delay``, cut at three
    of them and at zero. ``bad_to_good`` above zero makes the loss bursty: the chain enters the
    lossy state with ``good_to_bad`` and loses everything there (Gilbert, 1960), on top of ``loss``.
    A reordered datagram is kept back by ``reorder_delay``.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    good_to_bad: float = 0.0
    bad_to_good: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    reorder_delay: float = 0.02
    corrupt: float = 0.0


@dataclass(slots=True)
class Injected:
    """What was done so far."""

    passed: int = 0
    lost: int = 0
    copies: int = 0
    """Second copies, corrupted ones included."""
    duplicated: int = 0
    """Second copies of what was not corrupted."""
    reordered: int = 0
    corrupted: int = 0
    """Corrupted datagrams delivered, second copies included."""
    delays: list[float] = field(default_factory=list[float])
    """Delay given to each datagram that was passed on (s), copies left out."""
    outcomes: list[bool] = field(default_factory=list[bool])
    """For each datagram in order, whether it was lost."""


class Impairer:
    """Decides what becomes of each datagram of one direction."""

    def __init__(self, impairment: BadNetwork, seed: int) -> None:
        self.impairment = impairment
        self.injected = Injected()
        self._random = random.Random(seed)
        self._bad = False

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        """When (ns) to deliver what, for a datagram that was sent at ``now`` (ns)."""
        what, done, draw = self.impairment, self.injected, self._random.random
        lost = draw() < what.loss
        if what.bad_to_good > 0.0:
            change = what.bad_to_good if self._bad else what.good_to_bad
            if draw() < change:
                self._bad = not self._bad
            lost = lost or self._bad
        done.outcomes.append(lost)
        if lost:
            done.lost += 1
            return []
        delay = what.delay
        if what.jitter > 0.0:
            normal = self._random.gauss(0.0, 1.0)
            delay += what.jitter * min(max(normal, -_JITTER_BOUND), _JITTER_BOUND)
            delay = max(0.0, delay)
        if draw() < what.reorder:
            delay += what.reorder_delay
            done.reordered += 1
        corrupt = bool(datagram) and draw() < what.corrupt
        if corrupt:
            place = int(draw() * len(datagram))
            changed = bytearray(datagram)
            changed[place] ^= 1 << int(draw() * 8)
            datagram = bytes(changed)
        done.passed += 1
        done.delays.append(delay)
        due = now + round(delay * 1e9)
        deliveries = [(due, datagram)]
        if draw() < what.duplicate:
            deliveries.append((due, datagram))
            done.copies += 1
        if corrupt:
            done.corrupted += len(deliveries)
        else:
            done.duplicated += len(deliveries) - 1
        return deliveries
