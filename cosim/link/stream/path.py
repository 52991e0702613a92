"""How long packets take on this link, and how late they may come: measured, and bounded."""

from __future__ import annotations

from collections import deque

from cosim.link.wire.packet import LOW_HALF

WINDOW = 1_000_000_000
"""ns of which the lowest round trip counts: a lasting change is believed after one to two."""


class RoundTrips:
    """The lowest round trip of the last one to two seconds (ns)."""

    def __init__(self) -> None:
        self.lowest: int | None = None
        self._since: int | None = None
        self._before: int | None = None
        self._now: int | None = None

    def add(self, trip: int, at: int) -> None:
        """One round trip that ended at own time ``at``."""
        if self._since is None or at - self._since >= WINDOW:
            # After a silence the window of before says nothing any more.
            stale = self._since is not None and at - self._since >= 2 * WINDOW
            self._before = None if stale else self._now
            self._now, self._since = trip, at
        elif self._now is None or trip < self._now:
            self._now = trip
        before = self._before
        self.lowest = self._now if before is None or self._now < before else before

    def preset(self, trip: int) -> None:
        """What the handshake has measured, until data say more."""
        if self.lowest is None:
            self.lowest = trip


class Acknowledgements:
    """For how long the peer has acknowledged nothing newer; ticks are session ticks."""

    def __init__(self, capacity: int = 1024) -> None:
        self.newest: int | None = None
        """The tick at which the newest acknowledged packet was sent."""
        self._capacity = capacity
        self._sent: dict[int, deque[tuple[int, int]]] = {}
        """Of the present session and the one before: sequence and tick of what is on its way."""

    def begin(self, session: int) -> None:
        """Packets are sent under ``session`` from now on."""
        self._sent[session & LOW_HALF] = deque(maxlen=self._capacity)
        while len(self._sent) > 2:
            del self._sent[next(iter(self._sent))]

    def sent(self, session: int, sequence: int, tick: int) -> None:
        """A packet was sent."""
        self._sent[session & LOW_HALF].append((sequence, tick))

    def heard(self, session: int, sequence: int) -> None:
        """The peer says that it has received ``sequence`` of ``session`` (its low half).

        What was never sent, or longer ago than is remembered, says nothing.
        """
        waiting = self._sent.get(session)
        if not waiting or sequence > waiting[-1][0]:
            return
        while waiting and waiting[0][0] <= sequence:
            number, tick = waiting.popleft()
            if number == sequence:
                self.newest = tick if self.newest is None else max(self.newest, tick)
