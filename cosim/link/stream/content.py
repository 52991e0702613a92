"""A source that repeats itself: what it said last is not said again to who has it.

A deadband at the source holds its values while nobody could feel the difference, and says so in
its status. Such a packet carries only how the source is, once the peer has acknowledged one with
the values; until then it repeats them, so that a lost packet costs no more than it does elsewhere.
"""

from __future__ import annotations

from cosim.link.stream.bundle import FieldRole, Floats, PacketBundle
from cosim.link.wire.packet import LOW_HALF

REPEATED = 128
"""Bit of a status field: the values are those of an earlier sample, and are meant to be."""


class SentContent:
    """The sender's side, for one stream."""

    def __init__(self, bundle: PacketBundle) -> None:
        self.withheld = 0
        """Packets that went out without content."""
        self._head = bundle.head
        # What has nothing to withhold says no more than any other source.
        self._statuses = bundle.indices(FieldRole.STATUS) if len(self._head) < bundle.size else []
        self._tick: int | None = None
        """Session tick of the values that are repeated."""
        self._bytes = b""
        self._session = 0
        self._first: int | None = None
        """Sequence, in this session, of the first packet that has these values."""
        self._last = -1
        self._has_it = False

    def begin(self, session: int) -> None:
        """Packets are sent under ``session`` from now on."""
        self._session, self._first, self._has_it = session & LOW_HALF, None, False
        self._last = -1

    def of(self, tick: int, values: Floats) -> tuple[int, bool]:
        """From which session tick on the values count, and whether the peer has them already."""
        repeated = bool(self._statuses) and self._is_repeated(values)
        if not repeated or self._tick is None:
            self._tick, self._bytes = tick, b""
            self._first, self._has_it = None, False
            return tick, False
        content = self._content(values)
        if content != self._bytes:
            # Something goes on beside what is repeated.
            self._bytes, self._first, self._has_it = content, None, False
        return self._tick, self._has_it

    def sent(self, sequence: int, *, withheld: bool) -> None:
        """What :meth:`of` was asked about was sent."""
        self.withheld += withheld
        self._last = sequence
        if self._first is None and self._bytes:
            self._first = sequence

    def acknowledged(self, session: int, sequence: int) -> None:
        """The peer has received ``sequence`` of ``session`` (its low half)."""
        if session != self._session or self._first is None:
            return
        # From the first packet of these values on, every one had them until now.
        if self._first <= sequence <= self._last:
            self._has_it = True

    def _is_repeated(self, values: Floats) -> bool:
        return all(int(values[place]) & REPEATED for place in self._statuses)

    def _content(self, values: Floats) -> bytes:
        found = values.copy()
        found[self._head] = 0.0
        return found.tobytes()


class ReceivedContent:
    """The receiver's side: the newest values that came, whatever was made of them."""

    def __init__(self, bundle: PacketBundle) -> None:
        self.withheld = 0
        """Packets that came without content."""
        self.tick = -1
        """Session tick from which on they count."""
        self.bytes = memoryview(bytearray(8 * bundle.size))
        self._order = (0, -1)

    def take(self, tick: int, content: memoryview, order: tuple[int, int]) -> None:
        """Keep the values of a packet."""
        if order > self._order:
            self.tick, self._order = tick, order
            self.bytes[:] = content
