"""A world in simulated time: skewed clocks and a network between them, no sockets, no waiting."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

from cosim.testing.impairment import BadNetwork, Impairer


@dataclass
class SkewedClock:
    """A clock of true time: offset (ns) and rate error (parts of one)."""

    offset: int = 0
    skew: float = 0.0

    def at(self, true: int) -> int:
        return self.offset + true + round(self.skew * true)

    def true(self, own: int) -> int:
        return round((own - self.offset) / (1.0 + self.skew))


@dataclass
class Network:
    """Delivers datagrams between named stations after what each direction's impairer decides."""

    impairers: dict[tuple[str, str], Impairer] = field(default_factory=dict)
    now: int = 0
    sent: int = 0
    _queue: list = field(default_factory=list)
    _order: Callable[[], int] = field(default_factory=lambda: itertools.count().__next__)

    def join(self, a: str, b: str, impairment: BadNetwork, seed: int = 1) -> None:
        self.impairers[a, b] = Impairer(impairment, seed)
        self.impairers[b, a] = Impairer(impairment, seed + 1)

    def send(self, source: str, target: str, datagram: bytes) -> None:
        self.sent += 1
        for due, content in self.impairers[source, target].take(bytes(datagram), self.now):
            heapq.heappush(self._queue, (due, self._order(), source, target, content))

    def next_due(self) -> int | None:
        return self._queue[0][0] if self._queue else None

    def deliver(self, until: int):
        """Yield (due, source, target, datagram) up to a true time, in order of arrival."""
        while self._queue and self._queue[0][0] <= until:
            due, _, source, target, content = heapq.heappop(self._queue)
            yield due, source, target, content
