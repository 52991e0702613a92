"""What becomes of an arriving data packet: checked, counted, held for its sample, released.

Freshest value wins. A packet is opened first; only an authentic one can change anything but a
counter. Its contents are checked after that, because a key proves who sent a value and not that
the value makes sense.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from cosim.link.bundle import Bundle, Floats
from cosim.link.packet import HEADER, MAGIC, VERSION, DataReader, Flag, Kind, Opener

WINDOW = 128
"""Sequences back from the highest for which a second copy is told from a first, late one."""
WINDOW_MASK = (1 << WINDOW) - 1
WAITING_SLOTS = 16


class Fate(IntEnum):
    """What became of a datagram; only the first is used, all are counted."""

    ACCEPTED = 0
    LATE = 1
    """Authentic, but older than the link allows: a packet that was kept back on the way."""
    REORDERED = 2
    """Overtaken by a newer packet whose values are already held."""
    DUPLICATE = 3
    """A second copy of a packet of the last :data:`WINDOW` sequences."""
    REPLAYED = 4
    """Authentic, but older than the window: a copy cannot be told from an original."""
    FORGED = 5
    TRUNCATED = 6
    """Not as long as a packet of its kind and stream."""
    FOREIGN = 7
    """Another protocol, version or session (another key, or an earlier session's packet)."""
    OUT_OF_RANGE = 8
    """A value not finite, or outside its variable's range."""
    JUMP = 9
    """A value that changed faster than its variable can."""
    FLOOD = 10
    """Not looked at: more datagrams than a tick may read."""
    SUPERSEDED = 11
    """Accepted (and counted as that, too), but a newer one came before its sample did."""


class Release(StrEnum):
    """When an accepted packet's values are shown."""

    NETWORK_TICK = "network_tick"
    ARRIVAL = "arrival"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReceiverSettings:
    """How a stream is released and when it is too old.

    ``delay`` is the least delay in samples of the stream (a packet that arrives sooner waits),
    ``late_after`` the age in base ticks at which a packet is dropped, ``early`` by how many base
    ticks the two grids may differ before a packet from the future is refused.
    """

    release: Release = Release.NETWORK_TICK
    delay: int = 1
    late_after: int = 256
    early: int = 16


class Receiver:
    """Receives one stream. ``values``, ``tick`` and ``sequence`` are those now held.

    Nothing grows with the number of packets: slots, scratch and counters are allocated here.
    """

    def __init__(self, bundle: Bundle, settings: ReceiverSettings) -> None:
        size = bundle.size
        self.bundle = bundle
        self.settings = settings
        self.values: Floats = np.zeros(size)
        """Shape (size,): the held values."""
        self.tick = -1
        """Session tick at which the held values were sampled; -1 before the first."""
        self.sequence = -1
        self.released_at = -1
        """Session tick at which the held values were released."""
        self.counts: NDArray[np.int64] = np.zeros(len(Fate), dtype=np.int64)
        """By :class:`Fate`."""
        self.overdue = 0
        """Accepted packets that missed the sample their delay meant them for."""
        self.stopping = False
        """The peer has announced an orderly stop."""
        self.slip = 0
        """Base ticks added to a packet's tick, where the two grids slide (``clock: free``)."""
        self.highest = -1
        """Highest authentic sequence of this session."""
        self.last_times = (0, 0, 0)
        """sent, echo_sent, echo_received (ns) of the last authentic packet."""
        self.peer_epoch = 0
        """Where the peer's clock (ns) has session tick 0 on the peer's present grid."""
        self.acknowledged = -1
        """Highest own sequence that the peer says it has received."""
        self._seen = 0
        self._minimum = bundle.spread("minimum")
        self._maximum = bundle.spread("maximum")
        self._step = bundle.spread("speed") * float(bundle.tick)
        self._reference: Floats = np.zeros(size)
        self._reference_tick: int | None = None
        self._scratch: Floats = np.zeros(size)
        self._mask = np.zeros(size, dtype=np.bool_)
        self._slots: Floats = np.zeros((WAITING_SLOTS, size))
        self._slot_sequence = [-1] * WAITING_SLOTS
        self._slot_tick = [0] * WAITING_SLOTS
        self._slot_due = [0] * WAITING_SLOTS
        self._reader: DataReader | None = None

    def renew(self, opener: Opener | None) -> None:
        """Go on under a new session; the held values stay until one of its packets is released."""
        self._reader = None if opener is None else DataReader(opener, self.bundle.size)
        self.highest = -1
        self.sequence = -1
        self._seen = 0
        self._reference_tick = None
        self.stopping = False
        self._slot_sequence = [-1] * WAITING_SLOTS

    def allow(self, *, late_after: int) -> None:
        """Set the age (base ticks) at which a packet is dropped."""
        self.settings = replace(self.settings, late_after=late_after)

    def accept(self, datagram: memoryview, now: int) -> Fate:
        """Take a datagram whose header names this stream, at session tick ``now``."""
        fate = self._judge(datagram, now)
        self.counts[fate] += 1
        return fate

    def take_initial(self, datagram: memoryview) -> bool:
        """Before the start: hold the values that the peer has at its first tick."""
        reader = self._reader
        if reader is None or len(datagram) != reader.size or not self._ours(datagram, reader):
            return False
        opened = reader.open(datagram)
        if opened is None or not self._in_range(reader.values) or not opened[6] & Flag.INITIAL:
            return False
        np.copyto(self.values, reader.values)
        return True

    def release(self, now: int) -> bool:
        """At session tick ``now``, show the freshest values that are due; whether there are any."""
        best = -1
        for slot, sequence in enumerate(self._slot_sequence):
            due = sequence >= 0 and self._slot_due[slot] <= now
            if due and (best < 0 or sequence > self._slot_sequence[best]):
                best = slot
        if best < 0:
            return False
        self.sequence = self._slot_sequence[best]
        self.tick = self._slot_tick[best]
        self.released_at = now
        np.copyto(self.values, self._slots[best])
        self._slot_sequence[best] = -1
        for slot, sequence in enumerate(self._slot_sequence):
            if 0 <= sequence < self.sequence:
                self._slot_sequence[slot] = -1
                self.counts[Fate.SUPERSEDED] += 1
        return True

    def _ours(self, datagram: memoryview, reader: DataReader) -> bool:
        magic, version, kind, stream, zero, session, _ = HEADER.unpack_from(datagram)
        return (
            magic == MAGIC
            and version == VERSION
            and kind == Kind.DATA
            and stream == self.bundle.stream
            and zero == 0
            and session == reader.opener.session
        )

    def _judge(self, datagram: memoryview, now: int) -> Fate:
        reader = self._reader
        if len(datagram) < HEADER.size:
            return Fate.TRUNCATED
        if reader is None or not self._ours(datagram, reader):
            return Fate.FOREIGN
        if len(datagram) != reader.size:
            return Fate.TRUNCATED
        opened = reader.open(datagram)
        if opened is None:
            return Fate.FORGED
        sequence: int = HEADER.unpack_from(datagram)[6]
        fate = self._first_copy(sequence)
        if fate is not Fate.ACCEPTED:
            return fate
        sampled, sent, echo_sent, echo_received, epoch, acknowledged, flags, _ = opened
        if flags & Flag.INITIAL:
            return Fate.LATE
        # Clock and grid are told by every authentic packet, also by one whose values are too old:
        # how old it is cannot be known before the two grids are.
        self.last_times = (sent, echo_sent, echo_received)
        self.peer_epoch = epoch
        self.acknowledged = acknowledged
        tick = sampled + self.slip
        if sequence < self.sequence:
            return Fate.REORDERED
        if not -self.settings.early <= now - tick <= self.settings.late_after:
            return Fate.LATE
        if not self._in_range(reader.values):
            return Fate.OUT_OF_RANGE
        if self._jumps(reader.values, sampled):
            return Fate.JUMP
        if flags & Flag.STOPPING:
            self.stopping = True
        self._keep(reader.values, sequence, tick, now)
        return Fate.ACCEPTED

    def _first_copy(self, sequence: int) -> Fate:
        """Mark an authentic sequence as seen (RFC 6479's sliding window as one integer)."""
        ahead = sequence - self.highest
        if ahead > 0:
            self._seen = ((self._seen << ahead) | 1) & WINDOW_MASK if ahead < WINDOW else 1
            self.highest = sequence
            return Fate.ACCEPTED
        if -ahead >= WINDOW:
            return Fate.REPLAYED
        bit = 1 << -ahead
        if self._seen & bit:
            return Fate.DUPLICATE
        self._seen |= bit
        return Fate.ACCEPTED

    def _in_range(self, values: Floats) -> bool:
        # A NaN compares false with everything, so both conditions have to hold.
        np.greater_equal(values, self._minimum, out=self._mask)
        if not self._mask.all():
            return False
        np.less_equal(values, self._maximum, out=self._mask)
        return bool(self._mask.all())

    def _jumps(self, values: Floats, sampled: int) -> bool:
        last = self._reference_tick
        if last is not None:
            # At least one sample: two packets of one tick still differ by what a tick allows.
            ticks = max(abs(sampled - last), self.bundle.period)
            np.subtract(values, self._reference, out=self._scratch)
            np.abs(self._scratch, out=self._scratch)
            self._scratch /= ticks
            np.greater(self._scratch, self._step, out=self._mask)
            if self._mask.any():
                return True
        np.copyto(self._reference, values)
        self._reference_tick = sampled
        return False

    def _keep(self, values: Floats, sequence: int, tick: int, now: int) -> None:
        """Put accepted values into a waiting slot, due when the release policy says."""
        slot = min(range(WAITING_SLOTS), key=self._slot_sequence.__getitem__)
        if self._slot_sequence[slot] >= 0:
            self.counts[Fate.SUPERSEDED] += 1
        due = now
        if self.settings.release is Release.NETWORK_TICK:
            period = self.bundle.period
            due = max(-(-now // period) * period, tick + self.settings.delay * period)
            if due > tick + self.settings.delay * period:
                self.overdue += 1
        np.copyto(self._slots[slot], values)
        self._slot_sequence[slot] = sequence
        self._slot_tick[slot] = tick
        self._slot_due[slot] = due
