"""What becomes of an arriving data packet: checked, counted, held for its sample, released.

Freshest value wins. A packet is opened first; only an authentic one can change anything but a
counter. Its contents are checked after that, because a key proves who sent a value and not that
the value makes sense.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cosim.link.stream.admission import Admission, PacketJudge, Plausibility
from cosim.link.stream.bundle import Floats, PacketBundle
from cosim.link.stream.content import ReceivedContent
from cosim.link.stream.fate import Fate
from cosim.link.stream.waiting import WaitingPackets
from cosim.link.wire.packet import (
    FLAGS,
    HEADER,
    LARGEST_TIME,
    MAGIC,
    VERSION,
    DataReader,
    Opener,
    PacketFlag,
    PacketKind,
)
from cosim.link.wire.window import WINDOW, ReplayWindow

SESSIONS = 3
"""Sessions that a stream is read under at most: the present, the one before, and a candidate."""
LARGEST_TICK = 1 << 53
"""A session tick beyond it (a quarter of a million years) is no tick."""


class Release(StrEnum):
    """When an accepted packet's values are shown."""

    NETWORK_TICK = "network_tick"
    ARRIVAL = "arrival"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReceiverSettings:
    """How a stream is released and when it is too old.

    ``delay`` is the least delay in samples of the stream (a packet that arrives sooner waits),
    ``longest_wait`` what it may be set to later, ``late_after`` the age in base ticks at which a
    packet is dropped, ``early`` by how many base ticks the two grids may differ before a packet
    from the future is refused.
    """

    release: Release = Release.NETWORK_TICK
    delay: int = 1
    longest_wait: int = 1
    late_after: int = 256
    early: int = 16


@dataclass(slots=True)
class _Inbound:
    """What a stream is read with under one session."""

    reader: DataReader
    expected: tuple[object, ...]
    """What the header must say before the sequence."""
    window: ReplayWindow
    order: int
    """Counts the sessions: packets of a later one are newer whatever their sequences."""


class Receiver:
    """Receives one stream. ``values``, ``tick`` and ``sequence`` are those now held.

    Nothing grows with the number of packets: scratch and counters are allocated here.
    """

    def __init__(
        self, bundle: PacketBundle, settings: ReceiverSettings, judge: PacketJudge | None = None
    ) -> None:
        """``judge`` looks at the values; one in NumPy where none is given."""
        size = bundle.size
        self.bundle = bundle
        self.settings = settings
        self.values: Floats = np.zeros(size)
        """Shape (size,): the held values."""
        self.tick = -1
        """Session tick at which the held values were sampled; -1 before the first."""
        self.sequence = -1
        self.sample = -1
        """Which of its sender's samples the held values are, counted from the session's tick 0."""
        self.released_at = -1
        """Session tick at which the held values were released."""
        self.delay = -1
        """Base ticks from their sample to their release."""
        self.tally = [0] * len(Fate)
        """How many datagrams met each :class:`Fate`."""
        self.overdue = 0
        """Accepted packets that missed the sample their delay meant them for."""
        self.repeated = 0
        """For how many base ticks the held values had been the same when they were sent."""
        self.content = ReceivedContent(bundle)
        self.stopping = False
        """The peer has announced an orderly stop."""
        self.slip = 0
        """Base ticks added to a packet's tick, where the two grids slide (``clock: free``)."""
        self.last_times = (0, 0, 0)
        """sent, echo_sent, echo_received (ns) of the last authentic packet."""
        self.last_late = -1
        """Session tick at which a packet last came that was too old to be used."""
        self.peer_epoch = 0
        """Where the peer's clock (ns) has session tick 0 on the peer's present grid."""
        self.acknowledged = (0, -1)
        """Session (its low half) and the highest own sequence there that the peer has received."""
        self.newest = (0, -1)
        """The latest session under which anything was received, and the highest sequence there."""
        self.held = False
        """Show nothing new: a peer that fades does so on the values that it was given up with."""
        self._admission: PacketJudge = judge or Admission(bundle)
        self._reference_tick: int | None = None
        self._reference_order = (0, -1)
        self._stopped_in = 0
        # Copied as bytes: with cold caches a call of NumPy costs several microseconds.
        self._held_bytes = self.values.data.cast("B")
        self._waiting = WaitingPackets(size, max(settings.delay, settings.longest_wait))
        self._inbound: dict[int, _Inbound] = {}
        self._offered = 0
        self._newest_order = 0
        self._held_order = (0, -1)
        """Session's place and sequence of the held values."""

    @property
    def counts(self) -> NDArray[np.int64]:
        """:attr:`tally` as an array, shape (len(Fate),)."""
        return np.array(self.tally, dtype=np.int64)

    def highest(self, session: int) -> int:
        """Highest authentic sequence of a session; -1 for none."""
        inbound = self._inbound.get(session)
        return -1 if inbound is None else inbound.window.highest

    def offer(self, opener: Opener) -> None:
        """Read packets of one more session; the oldest of more than three is forgotten."""
        if opener.session in self._inbound:
            return
        stream = self.bundle.stream
        self._offered += 1
        self._inbound[opener.session] = _Inbound(
            DataReader(opener, stream, self.bundle.size, self.bundle.head),
            (MAGIC, VERSION, int(PacketKind.DATA), stream, 0, opener.session),
            ReplayWindow(),
            self._offered,
        )
        while len(self._inbound) > SESSIONS:
            del self._inbound[next(iter(self._inbound))]

    def knows(self, session: int) -> bool:
        """Whether packets of a session can be read."""
        return session in self._inbound

    def allow(self, *, late_after: int) -> None:
        """Set the age (base ticks) at which a packet is dropped."""
        if late_after != self.settings.late_after:
            self.settings = replace(self.settings, late_after=late_after)

    def accept(self, datagram: memoryview, now: int) -> Fate:
        """Take a datagram whose header names this stream, at session tick ``now``."""
        fate = self._judge(datagram, now)
        self.tally[fate] += 1
        return fate

    def take_initial(self, datagram: memoryview) -> bool:
        """Before the start: hold the values that the peer has at its first tick."""
        if len(datagram) < HEADER.size:
            return False
        *header, sequence = HEADER.unpack_from(datagram)
        inbound = self._inbound.get(header[5])
        if inbound is None or tuple(header) != inbound.expected:
            return False
        reader = inbound.reader
        if len(datagram) != reader.size:
            return False
        opened = reader.open(datagram, sequence)
        if opened is None or not opened[6] & PacketFlag.INITIAL:
            return False
        if not self._admission.in_range(reader.values):
            self.tally[Fate.OUT_OF_RANGE] += 1
            return False
        np.copyto(self.values, reader.values)
        return True

    def release(self, now: int) -> bool:
        """At session tick ``now``, show the freshest values that are due; whether there are any."""
        waiting = self._waiting
        if now < waiting.next_due or self.held:
            return False
        order, self.tick, sampled, superseded, self.repeated = waiting.take(now, self._held_bytes)
        self._held_order, self.sequence = order, order[1]
        self.sample = sampled // self.bundle.period
        self.released_at = now
        self.delay = now - self.tick
        self.tally[Fate.SUPERSEDED] += superseded
        return True

    def _judge(self, datagram: memoryview, now: int) -> Fate:
        if len(datagram) < HEADER.size:
            return Fate.TRUNCATED
        header = HEADER.unpack_from(datagram)
        inbound = self._inbound.get(header[5])
        if inbound is None or header[:6] != inbound.expected:
            return Fate.FOREIGN
        reader = inbound.reader
        withheld = len(datagram) != reader.size
        if withheld and len(datagram) != reader.withheld_size:
            return Fate.TRUNCATED
        sequence: int = header[6]
        opened = reader.open(datagram, sequence)
        if opened is None:
            return Fate.FORGED
        window = inbound.window
        if not window.is_first(sequence):
            if sequence > window.highest:
                return Fate.ABSURD
            return Fate.REPLAYED if window.highest - sequence >= WINDOW else Fate.DUPLICATE
        newest = inbound.order >= self._newest_order and sequence == window.highest
        if inbound.order >= self._newest_order:
            self._newest_order = inbound.order
            self.newest = (header[5], window.highest)
        sampled, sent, echo_sent, echo_received, epoch, acknowledged, flags, of, content = opened
        latest = max(sent, echo_sent, echo_received, epoch)
        earliest = min(sent, echo_sent, echo_received, epoch)
        if not 0 <= sampled <= LARGEST_TICK or latest > LARGEST_TIME or earliest < -LARGEST_TIME:
            return Fate.ABSURD
        if flags > FLAGS or not 0 <= content <= sampled:
            return Fate.ABSURD
        if withheld is not bool(flags & PacketFlag.WITHHELD):
            return Fate.ABSURD
        if flags & PacketFlag.INITIAL:
            return Fate.LATE
        # Clock and grid are told by every authentic packet, also by one whose values are too old:
        # how old it is cannot be known before the two grids are.
        self.last_times = (sent, echo_sent, echo_received)
        if newest:  # an older one says where the grid was before its loop was late
            self.peer_epoch = epoch
        self.acknowledged = (of, acknowledged)
        order = (inbound.order, sequence)
        if withheld:
            if content > self.content.tick:
                return Fate.ABSURD
            if content < self.content.tick:
                return Fate.REORDERED
            self.content.withheld += 1
            reader.complete(self.content.bytes)
        elif content < sampled:
            self.content.take(content, reader.content, order)
        if order < self._held_order:
            return Fate.REORDERED
        tick = sampled + self.slip
        if not -self.settings.early <= now - tick <= self.settings.late_after:
            self.last_late = now
            return Fate.LATE
        return self._admit(reader.values, order, (sampled, tick, now, sampled - content), flags)

    def _admit(
        self, values: Floats, order: tuple[int, int], at: tuple[int, int, int, int], flags: int
    ) -> Fate:
        """Judge the values themselves, and keep them where they can be believed."""
        sampled, tick, now, repeated = at
        last = self._reference_tick
        # At least one sample: two packets of one tick still differ by what a tick allows.
        ticks = 0 if last is None else max(abs(sampled - last), self.bundle.period)
        waiting = self._waiting
        self.tally[Fate.SUPERSEDED] += waiting.make_room()
        newest = last is None or order > self._reference_order
        verdict = self._admission.judge(values, ticks, waiting.spare, newest=newest)
        if verdict is Plausibility.OUT_OF_RANGE:
            return Fate.OUT_OF_RANGE
        if verdict is Plausibility.JUMP:
            return Fate.JUMP
        if newest:
            self._reference_tick, self._reference_order = sampled, order
        if flags & PacketFlag.STOPPING:
            self.stopping, self._stopped_in = True, order[0]
        elif order[0] > self._stopped_in:
            # A session of after the stop: the peer is there again.
            self.stopping = False
        due = now
        if self.settings.release is Release.NETWORK_TICK:
            period = self.bundle.period
            wanted = tick + self.settings.delay * period
            due = -(-now // period) * period
            if due > wanted:
                self.overdue += 1
            else:
                due = wanted
        waiting.keep(order, tick, sampled, due, repeated)
        return Fate.ACCEPTED
