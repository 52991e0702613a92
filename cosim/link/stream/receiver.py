"""What becomes of an arriving data packet: checked, counted, held for its sample, released.

Freshest value wins. A packet is opened first; only an authentic one can change anything but a
counter. Its contents are checked after that, because a key proves who sent a value and not that
the value makes sense.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from cosim.link.stream.bundle import Bundle, Floats
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, DataReader, Flag, Kind, Opener

WINDOW = 128
"""Sequences back from the highest for which a second copy is told from a first, late one."""
WINDOW_MASK = (1 << WINDOW) - 1
WAITING_SLOTS = 16
LARGEST_VALUE = sys.float_info.max / 2.0
"""What a field without a range may hold: not infinity, and two of them have a difference."""
_NEVER = sys.maxsize


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
        self.delay = -1
        """Base ticks from their sample to their release."""
        """Session tick at which the held values were released."""
        self.tally = [0] * len(Fate)
        """How many datagrams met each :class:`Fate`."""
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
        self._minimum = np.maximum(bundle.spread("minimum"), -LARGEST_VALUE)
        self._maximum = np.minimum(bundle.spread("maximum"), LARGEST_VALUE)
        self._step = bundle.spread("speed") * float(bundle.tick)
        self._sample_step = self._step * bundle.period
        self._reference: Floats = np.zeros(size)
        self._reference_tick: int | None = None
        self._scratch: Floats = np.zeros(size)
        # Comparisons write into bytes: to look for a 0 there takes a tenth of NumPy's ``all``.
        self._passed = bytearray(2 * size)
        self._above = np.frombuffer(self._passed, dtype=np.bool_, count=size)
        self._below = np.frombuffer(self._passed, dtype=np.bool_, count=size, offset=size)
        self._slots: Floats = np.zeros((WAITING_SLOTS, size))
        self._slot_sequence = [0] * WAITING_SLOTS
        self._slot_tick = [0] * WAITING_SLOTS
        self._slot_due = [0] * WAITING_SLOTS
        self._free = list(range(WAITING_SLOTS))
        self._waiting: list[int] = []
        """Slots in use, mostly one or none."""
        self._next_due = _NEVER
        """Session tick at which the first waiting packet is due."""
        self._reader: DataReader | None = None
        self._expected: tuple[object, ...] = ()
        """What the header must say before the sequence."""

    @property
    def counts(self) -> NDArray[np.int64]:
        """:attr:`tally` as an array, shape (len(Fate),)."""
        return np.array(self.tally, dtype=np.int64)

    def renew(self, opener: Opener | None) -> None:
        """Go on under a new session; the held values stay until one of its packets is released."""
        self._reader = None
        if opener is not None:
            stream = self.bundle.stream
            self._reader = DataReader(opener, stream, self.bundle.size)
            self._expected = (MAGIC, VERSION, int(Kind.DATA), stream, 0, opener.session)
        self.highest = -1
        self.sequence = -1
        self._seen = 0
        self._reference_tick = None
        self.stopping = False
        self._set_free(list(self._waiting))

    def allow(self, *, late_after: int) -> None:
        """Set the age (base ticks) at which a packet is dropped."""
        self.settings = replace(self.settings, late_after=late_after)

    def accept(self, datagram: memoryview, now: int) -> Fate:
        """Take a datagram whose header names this stream, at session tick ``now``."""
        fate = self._judge(datagram, now)
        self.tally[fate] += 1
        return fate

    def take_initial(self, datagram: memoryview) -> bool:
        """Before the start: hold the values that the peer has at its first tick."""
        reader = self._reader
        if reader is None or len(datagram) != reader.size:
            return False
        *header, sequence = HEADER.unpack_from(datagram)
        if tuple(header) != self._expected:
            return False
        opened = reader.open(datagram, sequence)
        if opened is None or not self._in_range(reader.values) or not opened[6] & Flag.INITIAL:
            return False
        np.copyto(self.values, reader.values)
        return True

    def release(self, now: int) -> bool:
        """At session tick ``now``, show the freshest values that are due; whether there are any."""
        if now < self._next_due:
            return False
        sequences = self._slot_sequence
        due = [slot for slot in self._waiting if self._slot_due[slot] <= now]
        best = max(due, key=sequences.__getitem__)
        self.sequence = sequences[best]
        self.tick = self._slot_tick[best]
        self.released_at = now
        self.delay = now - self.tick
        np.copyto(self.values, self._slots[best])
        done = [slot for slot in self._waiting if sequences[slot] <= self.sequence]
        self.tally[Fate.SUPERSEDED] += len(done) - 1
        self._set_free(done)
        return True

    def _set_free(self, slots: list[int]) -> None:
        for slot in slots:
            self._waiting.remove(slot)
            self._free.append(slot)
        self._next_due = min([self._slot_due[slot] for slot in self._waiting], default=_NEVER)

    def _judge(self, datagram: memoryview, now: int) -> Fate:
        reader = self._reader
        if len(datagram) < HEADER.size:
            return Fate.TRUNCATED
        header = HEADER.unpack_from(datagram)
        if reader is None or header[:6] != self._expected:
            return Fate.FOREIGN
        if len(datagram) != reader.size:
            return Fate.TRUNCATED
        sequence: int = header[6]
        opened = reader.open(datagram, sequence)
        if opened is None:
            return Fate.FORGED
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
        np.greater_equal(values, self._minimum, out=self._above)
        np.less_equal(values, self._maximum, out=self._below)
        return self._passed.find(0) < 0

    def _jumps(self, values: Floats, sampled: int) -> bool:
        last = self._reference_tick
        if last is not None:
            # At least one sample: two packets of one tick still differ by what a tick allows.
            ticks = max(abs(sampled - last), self.bundle.period)
            limit = self._sample_step if ticks == self.bundle.period else self._step * ticks
            np.subtract(values, self._reference, out=self._scratch)
            np.abs(self._scratch, out=self._scratch)
            np.less_equal(self._scratch, limit, out=self._below)
            # What was above the minimum in the range check still is.
            if self._passed.find(0) >= 0:
                return True
        np.copyto(self._reference, values)
        self._reference_tick = sampled
        return False

    def _keep(self, values: Floats, sequence: int, tick: int, now: int) -> None:
        """Put accepted values into a waiting slot, due when the release policy says."""
        if not self._free:
            # The oldest packet gives way.
            self._set_free([min(self._waiting, key=self._slot_sequence.__getitem__)])
            self.tally[Fate.SUPERSEDED] += 1
        slot = self._free.pop()
        self._waiting.append(slot)
        due = now
        if self.settings.release is Release.NETWORK_TICK:
            period = self.bundle.period
            wanted = tick + self.settings.delay * period
            due = -(-now // period) * period
            if due > wanted:
                self.overdue += 1
            else:
                due = wanted
        np.copyto(self._slots[slot], values)
        self._slot_sequence[slot] = sequence
        self._slot_tick[slot] = tick
        self._slot_due[slot] = due
        self._next_due = min(self._next_due, due)
