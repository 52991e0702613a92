"""The peer's clock against the own one, from the four timestamps that every packet carries.

Offset and skew come from a regression on the lowest round trips (after Mills, RFC 5905, and the
minimum filters used for one-way measurement). It assumes that the fastest packets take as long
there as back: half of any asymmetry is an error that no such exchange can see.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cosim.link.wire.packet import LARGEST_TIME

LONGEST_TRIP = 10_000_000_000
"""ns; what takes longer tells nothing about a clock."""
LARGEST_SKEW = 1.0e-3


class ClockEstimate:
    """Offset (peer - own, ns) and skew of a peer's clock; times are integer nanoseconds."""

    def __init__(
        self, *, capacity: int = 2560, fraction: float = 0.1, window: float = 20.0
    ) -> None:
        self._times: NDArray[np.int64] = np.zeros(capacity, dtype=np.int64)
        self._offsets: NDArray[np.int64] = np.zeros(capacity, dtype=np.int64)
        self._trips: NDArray[np.int64] = np.zeros(capacity, dtype=np.int64)
        self._ways: NDArray[np.int64] = np.zeros(capacity, dtype=np.int64)
        """Own time of arrival less the peer's time of sending."""
        # A memory view takes a plain number at a third of an array's cost.
        rings = (self._times, self._offsets, self._trips, self._ways)
        self._rings = tuple(ring.data for ring in rings)
        self._fraction = fraction
        self._window = int(window * 1e9)
        self._count = 0
        self._anchor_time = 0
        self._anchor_offset = 0.0
        self.skew = 0.0
        """Seconds that the peer's clock gains on the own one in a second."""
        self.round_trip = 0
        """Lowest round trip in the window (ns), time at the peer taken out."""
        self.last_round_trip = 0
        self.ready = False
        """Whether an estimate exists."""
        self.refused = 0
        """Exchanges that could not be true."""

    @property
    def samples(self) -> int:
        """Exchanges added so far."""
        return self._count

    def add(self, sent: int, peer_received: int, peer_sent: int, received: int) -> bool:
        """Add one exchange: own, peer's, peer's, own clock; whether it made sense."""
        trip = (received - sent) - (peer_sent - peer_received)
        absurd = not 0 <= trip < LONGEST_TRIP or sent > received
        if absurd or max(abs(peer_received), abs(peer_sent)) > LARGEST_TIME:
            self.refused += 1
            return False
        slot = self._count % len(self._times)
        times, offsets, trips, ways = self._rings
        times[slot] = received
        # Halving the sum last keeps the half nanosecond's error out of the difference.
        offsets[slot] = ((peer_received - sent) + (peer_sent - received)) // 2
        trips[slot] = trip
        ways[slot] = received - peer_sent
        self.last_round_trip = trip
        self._count += 1
        return True

    def update(self, now: int) -> None:
        """Fit offset and skew to the exchanges of the window; cheap enough for once a second."""
        size = min(self._count, len(self._times))
        recent = self._times[:size] > now - self._window
        kept = int(np.count_nonzero(recent))
        if kept == 0:
            return
        times = self._times[:size][recent]
        offsets = self._offsets[:size][recent]
        trips = self._trips[:size][recent]
        rank = max(0, int(np.ceil(kept * self._fraction)) - 1)
        threshold = int(np.partition(trips, rank)[rank])
        fast = trips <= threshold
        anchor = int(times[fast][0])
        base = int(offsets[fast][0])
        seconds = (times[fast] - anchor).astype(np.float64) * 1e-9
        residual = (offsets[fast] - base).astype(np.float64)
        middle = float(seconds.mean())
        spread = seconds - middle
        variance = float(spread @ spread)
        skew = 0.0
        # Two seconds and eight packets before a slope means more than noise.
        if len(seconds) >= 8 and float(np.ptp(seconds)) >= 2.0:
            skew = float(spread @ residual) / variance * 1e-9
        self.skew = min(max(skew, -LARGEST_SKEW), LARGEST_SKEW)
        self._anchor_time = anchor + int(middle * 1e9)
        self._anchor_offset = base + float(residual.mean())
        self.round_trip = int(trips.min())
        self.ready = True

    def offset(self, now: int) -> int:
        """Peer clock minus own clock at own time ``now`` (ns)."""
        return round(self._anchor_offset + self.skew * (now - self._anchor_time))

    def incoming(self, fraction: float) -> int:
        """The time (ns) from the peer to here that ``fraction`` of the packets keep."""
        size = min(self._count, len(self._times))
        if size == 0:
            return 0
        times, ways = self._times[:size], self._ways[:size]
        offsets = self._anchor_offset + self.skew * (times - self._anchor_time)
        return round(float(np.quantile(ways + offsets, fraction)))

    def forget(self) -> None:
        """Start again: a restarted peer has another clock."""
        self._count = 0
        self.ready = False
        self.skew = 0.0
