"""The loop's reading of its socket: bounded in every tick, newest first, floods kept out."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from cosim.link.wire.packet import HEADER, PacketKind
from cosim.link.wire.transport import LARGEST_READ, Transport

READ_AHEAD = Fraction(1, 2)
"""Seconds of packets that one tick reads: what a radio that slept hands over at once."""
LEAST_READS, MOST_READS = 32, 256
GUARD_TIME = Fraction(1)
"""Seconds for which the kernel filters after a tick that had more to read than that."""

Arrived = tuple[int, int, int, int]
"""Sequence, place of the buffer, size, time of arrival (ns)."""


class Intake:
    """Takes datagrams from a transport; ``rate`` is in packets a second, ``tick`` in seconds."""

    def __init__(self, transport: Transport, *, rate: Fraction, tick: Fraction) -> None:
        self.transport = transport
        self.reads = min(max(LEAST_READS, math.ceil(rate * READ_AHEAD)), MOST_READS)
        """Datagrams that a tick reads at most."""
        self.flood = 0
        """Datagrams thrown away unread."""
        self.buffers = [memoryview(bytearray(LARGEST_READ)) for _ in range(self.reads)]
        self._guard_ticks = round(GUARD_TIME / tick)
        self._guarded_until: int | None = None

    def read(
        self,
        tick: int,
        other: Callable[[memoryview], None],
        before: Callable[[], None] | None = None,
    ) -> tuple[list[Arrived], bool]:
        """The values that wait, newest first, and whether there was more than a tick may read.

        ``other`` takes what is no value; ``before`` is called before the first datagram is looked
        at, in a tick that has one.
        """
        if self._guarded_until is not None and tick >= self._guarded_until:
            self.let_everything_in()
        values: list[Arrived] = []
        receive, buffers = self.transport.receive, self.buffers
        count = 0
        while count < self.reads:
            size = receive(buffers[count])
            if size < 0:
                break
            if count == 0 and before is not None:
                before()
            datagram = buffers[count][:size]
            if size >= HEADER.size and datagram[3] == PacketKind.DATA:
                sequence = HEADER.unpack_from(datagram)[6]
                values.append((sequence, count, size, self.transport.arrival()))
            else:
                other(datagram)
            count += 1
        if len(values) > 1:
            values.sort(reverse=True)
        return values, count == self.reads

    def throw_away(self) -> bool:
        """Leave what is beyond a tick's reads unread; whether there was anything."""
        discarded = self.transport.discard()
        self.flood += discarded
        return discarded > 0

    def guard(self, tick: int, session: int, floor: int, *, handshakes: bool) -> None:
        """For a while let in only a session's packets from ``floor`` on, and maybe handshakes."""
        self.transport.guard(session, floor, handshakes=handshakes)
        self._guarded_until = tick + self._guard_ticks

    def let_everything_in(self) -> None:
        """End that."""
        if self._guarded_until is not None:
            self._guarded_until = None
            self.transport.unguard()
