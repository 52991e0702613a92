"""What became of each packet of a measurement, in memory that does not grow with its length.

The packets of the last while wait in a window for their replies. Those that leave it are judged:
losses and bursts are counted, times are kept, and of a measurement too long to keep whole, one
packet of each stretch, drawn at random.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cosim.link.netchar.bursts import LossPattern

Times = NDArray[np.int64]
KEPT: Final = 1 << 20
"""Packets whose times are kept at most: the thesis's 36 minutes at 128 Hz are a quarter of it."""
WINDOW: Final = 1 << 16
"""Packets that wait for their replies at least."""
SENT, RETURNED, RECEIVED, RELAYED = range(4)


class EchoKind(Enum):
    """What a reply with a packet's time is."""

    FIRST = auto()
    AGAIN = auto()
    LATE = auto()
    """Of a packet that was judged already."""
    EARLIER = auto()
    """Of an earlier measurement's packet."""
    UNKNOWN = auto()
    """Of no packet that was sent."""


def _columns(count: int) -> Times:
    return np.zeros((4, count), dtype=np.int64)


@dataclass(slots=True)
class KeptTimes:
    """Times (ns) of one packet in ``stride``, for at most ``capacity`` packets (an even number)."""

    capacity: int = KEPT
    stride: int = 1
    _count: int = 0
    _seen: int = 0
    _columns: Times = field(init=False)

    def __post_init__(self) -> None:
        self._columns = _columns(self.capacity)

    @property
    def columns(self) -> Times:
        """Sent, returned, received, relayed; shape (4, packets kept)."""
        return self._columns[:, : self._count]

    def add(self, columns: Times) -> None:
        """Go on with the next packets; ``columns`` has shape (4, packets)."""
        while columns.shape[1]:
            # Full where each stretch up to the capacity's end is over.
            if self._seen == self.capacity * self.stride:
                self._halve()
            part = min(columns.shape[1], self.capacity * self.stride - self._seen)
            numbers = np.arange(self._seen, self._seen + part, dtype=np.int64)
            stretch = numbers // self.stride
            chosen = columns[:, :part][:, numbers % self.stride == _draw(stretch) % self.stride]
            self._columns[:, self._count : self._count + chosen.shape[1]] = chosen
            self._count += chosen.shape[1]
            self._seen += part
            columns = columns[:, part:]

    def _halve(self) -> None:
        half = self.capacity // 2
        pairs = np.arange(half)
        self._columns[:, :half] = self._columns[:, 2 * pairs + (_draw(pairs + self._seen) & 1)]
        self._count = half
        self.stride *= 2


def _draw(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """The same at-random integers for the same numbers: nothing periodic may be met in step.

    Source: the finaliser of splitmix64 (Steele, Lea, Flood 2014).
    """
    mixed = numbers.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (mixed >> np.uint64(33)).astype(np.int64)


class NetworkMeasurement:
    """Give it each packet that leaves and each reply; times in ns, 0 where nothing came back.

    ``rate`` is in packets a second, ``size`` in bytes. A reply is waited for until ``window``
    further packets were sent; what comes after that is late, neither lost nor measured.
    """

    def __init__(
        self, rate: float, size: int, *, window: int = WINDOW, kept: int = KEPT, began: int = 0
    ) -> None:
        self.rate, self.size = rate, size
        self.began = began
        """Own time before the first packet."""
        self.count = 0
        """Packets sent."""
        self.returned = 0
        """Packets that came back in time."""
        self.late = 0
        """Packets that came back after they were given up."""
        self.late_replies = 0
        """Replies to an earlier measurement's packets: late, and not lost."""
        self.duplicates = self.forged = self.reordered = 0
        self.greetings = 0
        """Messages of the handshake that came when it was over: second copies, late ones."""
        self.capped = 0
        """Packets that came to the other side and were not relayed because of its caps."""
        self.unsent = 0
        """Packets that this computer could not send: a full queue, no route."""
        self.late_sends = 0
        """Packets sent more than half a period after their time."""
        self.first_sent = self.last_sent = 0
        self.shortest, self.longest = 0, 0
        """Round trips of all packets (ns), those whose times are not kept included."""
        self.relay_first: tuple[int, int] | None = None
        """Of the first packet back: its number, and how many the other side had received."""
        self.relay_last = (0, 0)
        """The same of the one with the highest count."""
        self.pattern = LossPattern()
        self.kept = KeptTimes(kept)
        self._judged = 0
        self._highest = -1
        self._window = window
        self._waiting = _columns(2 * window)

    @property
    def lost(self) -> int:
        """Packets that never came back, as far as those that were given up can tell."""
        return max(0, self.pattern.losses - self.late - self.unsent)

    def sent(self, now: int) -> None:
        """A packet left at ``now``, later than the one before."""
        at = self.count - self._judged
        if at == 2 * self._window:
            self._judge(self._window)
            at -= self._window
        if not self.count:
            self.first_sent = now
        self._waiting[:, at] = (now, 0, 0, 0)
        self.last_sent = now
        self.count += 1

    def reply(
        self, sent: int, received: int, relayed: int, arrived: int, relay_count: int
    ) -> EchoKind:
        """Note what came back for the packet that left at ``sent``, and count what it is."""
        if sent < self.began:
            self.late_replies += 1
            return EchoKind.EARLIER
        waiting = self._waiting[:, : self.count - self._judged]
        # Which packet this answers is told by its time, which no two packets share.
        at = int(np.searchsorted(waiting[SENT], np.int64(sent)))
        if self._judged and sent < waiting[SENT, 0]:
            self.late += 1
            return EchoKind.LATE
        if at >= waiting.shape[1] or waiting[SENT, at] != sent:
            self.forged += 1
            return EchoKind.UNKNOWN
        if waiting[RETURNED, at]:
            self.duplicates += 1
            return EchoKind.AGAIN
        waiting[1:, at] = (arrived, received, relayed)
        number = self._judged + at
        self.returned += 1
        self.reordered += number < self._highest
        self._highest = max(self._highest, number)
        trip = arrived - sent
        self.shortest = trip if self.returned == 1 else min(self.shortest, trip)
        self.longest = max(self.longest, trip)
        if self.relay_first is None:
            self.relay_first = (number, relay_count)
        if relay_count >= self.relay_last[1]:
            self.relay_last = (number, relay_count)
        return EchoKind.FIRST

    def end(self) -> None:
        """Nothing is waited for any longer."""
        self._judge(self.count - self._judged)

    def _judge(self, count: int) -> None:
        """Give up the first ``count`` packets that still wait."""
        waiting = self._waiting[:, : self.count - self._judged]
        self.pattern.add(waiting[RETURNED, :count] == 0)
        self.kept.add(waiting[:, :count])
        left = waiting.shape[1] - count
        self._waiting[:, :left] = waiting[:, count:].copy()
        self._judged += count
