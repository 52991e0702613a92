"""One peer as the loop sees it: drained once a tick, released, weighed, answered at its samples.

The handshake is not in here: its datagrams are passed on to the process that does it, and new
session keys come back from there.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from cosim.link.session.keys import SessionKeys
from cosim.link.stream.admission import Admission, PacketJudge
from cosim.link.stream.bundle import PacketBundle
from cosim.link.stream.fate import Fate
from cosim.link.stream.form import LinkForm
from cosim.link.stream.incoming import Incoming
from cosim.link.stream.intake import Intake
from cosim.link.stream.outgoing import Outgoing
from cosim.link.stream.path import RoundTrips
from cosim.link.stream.peer import PeerState, Reason
from cosim.link.stream.receiver import Receiver
from cosim.link.wire.clock import ClockEstimate
from cosim.link.wire.packet import HEADER, Opener, PacketFlag, PacketKind
from cosim.link.wire.transport import Transport

LIFE = Fraction(1, 4)
"""Seconds within which a live session has been heard and acknowledged."""
ACKNOWLEDGE_WITHIN = 4
"""Samples beyond the round trip: two until the acknowledgement is sent, two for lost ones."""
SESSIONS_KEPT = 64
LAST_WORDS = 3
"""Copies of the announcement that this side stops, because one may be lost."""
_TELLING = (Fate.ACCEPTED, Fate.LATE, Fate.REORDERED, Fate.OUT_OF_RANGE, Fate.JUMP)


class PeerLink:
    """Sends to and receives from one peer. Ticks are session ticks, times ns of the own clock."""

    def __init__(
        self,
        *,
        sends: Sequence[PacketBundle],
        receives: Sequence[PacketBundle],
        settings: Sequence[LinkForm],
        transport: Transport,
        forward: Callable[[memoryview, int], None],
        hear: Callable[[], None] = lambda: None,
        judge: Callable[[PacketBundle], PacketJudge] = Admission,
    ) -> None:
        """``settings`` has one for each incoming stream.

        ``forward`` takes what is not a value and when it came, to pass it on. ``hear`` is called
        when a session is not known yet: its keys may be waiting. ``judge`` makes what looks at the
        values of a stream.
        """
        self.transport = transport
        self.clock = ClockEstimate()
        self.incoming = [
            Incoming(bundle, setting, judge(bundle))
            for bundle, setting in zip(receives, settings, strict=True)
        ]
        self.outgoing = Outgoing(sends, transport, self._newest)
        bundles = (*receives, *sends)
        self._tick = bundles[0].tick if bundles else Fraction(1)
        self._period = max((bundle.period for bundle in bundles), default=1)
        rate = sum((1 / (b.tick * b.period) for b in receives), start=Fraction(0))
        self.intake = Intake(transport, rate=rate, tick=self._tick)
        self.peer_epoch = 0
        """Where the peer's clock has session tick 0 on its present grid (ns); 0: not known yet."""
        self.foreign = 0
        """Datagrams of no known kind or stream."""
        self.faulty = 0
        """Datagrams that the receive path could not cope with; always 0 unless it has an error."""
        self.before_start = 0
        """Value datagrams before the start that were none of the peer's first tick."""
        self.before_arrival: Callable[[], None] | None = None
        """Called in a tick in which something has arrived, before that is looked at."""
        self._forward, self._hear = forward, hear
        self.used: deque[int] = deque(maxlen=SESSIONS_KEPT)
        """The numbers of the sessions under which was sent, the last ones."""
        self._offered: dict[int, SessionKeys] = {}
        self._trips = RoundTrips()
        self._fitted: int | None = None
        self._longest_way = max((item.longest_way for item in self.incoming), default=0)
        self._round_trip_ticks = 2 * self._longest_way
        self._heard_at = 0

    @property
    def session(self) -> SessionKeys | None:
        """What is sent under."""
        return self.outgoing.session

    def offer(self, keys: SessionKeys, *, same: bool) -> None:
        """Read packets of a session; ``same``: the peer is the one of the session before.

        Sending goes on as before until :meth:`use`.
        """
        self._offered[keys.session] = keys
        while len(self._offered) > 2:
            del self._offered[next(iter(self._offered))]
        opener = Opener(keys.incoming, keys.session)
        for item in self.incoming:
            item.receiver.offer(opener)
        if not same:
            # Another process has another clock.
            self.clock.forget()
            self.peer_epoch = 0
            self.outgoing.echo = (0, 0)
        self.intake.let_everything_in()

    def use(self, session: int) -> bool:
        """Send under a session that was offered; whether it is a new one.

        A session is begun once: its sequences never start again.
        """
        keys = self._offered.pop(session, None)
        if keys is None:
            return False
        self.outgoing.use(keys)
        self.used.append(session)
        self.intake.let_everything_in()
        return True

    def expect(self, round_trip: int, incoming: int) -> None:
        """Before the start: what the clock exchanges have measured (ns).

        ``round_trip`` is the lowest one, ``incoming`` the time that nine packets of ten need from
        the peer to here; a stream with ``delay: auto`` waits that long, in whole samples.
        """
        self._trips.preset(round_trip)
        for item in self.incoming:
            receiver = item.receiver
            if item.setting.delay == "auto" and receiver.sequence < 0:
                sample = receiver.bundle.tick * receiver.bundle.period * 1_000_000_000
                delay = max(1, math.ceil(incoming / sample))
                receiver.settings = replace(
                    receiver.settings, delay=min(delay, item.setting.longest_wait)
                )
        self._fit()

    def drain(self, tick: int) -> None:
        """Read what has arrived, newest first; beyond a limit it is thrown away and counted."""
        intake = self.intake
        values, full = intake.read(tick, self._pass_on, self.before_arrival)
        if not values and not full:
            return
        for _, place, size, arrived in values:
            # Nothing that comes from outside may end the loop.
            try:
                self._take(intake.buffers[place][:size], tick, arrived)
            except Exception:
                self.faulty += 1
        if self._trips.lowest != self._fitted:
            self._fit()
        if full and intake.throw_away():
            self._guard(tick)

    def release(self, tick: int) -> None:
        """Show what is due at this tick and weigh the peer."""
        unheard, in_session = self._unheard(tick), self.session is not None
        for item in self.incoming:
            item.release(tick, unheard=unheard, in_session=in_session)

    def give_up(self, reason: Reason) -> None:
        """Fade the peer on the values that are held."""
        for item in self.incoming:
            item.weight.give_up(reason)
            item.receiver.held = item.weight.state is PeerState.FADING

    def ramp(self) -> None:
        """This station joins a session that runs: the peer comes with a ramp."""
        for item in self.incoming:
            item.weight.ramp()

    def alive(self, tick: int) -> int:
        """The session under which data come and are acknowledged; 0 for none."""
        if self.session is None or not self.incoming or not self.outgoing.bundles:
            return 0
        recent = LIFE / self._tick
        heard = self._heard_at > 0 and tick - self._heard_at <= recent
        return self.session.session if heard and self._unheard(tick) <= recent else 0

    def take_initial(self) -> bool:
        """Before the start: hold what the peer has sent of its first tick, if it has."""
        found = False
        buffer = self.intake.buffers[0]
        for _ in range(self.intake.reads):
            size = self.transport.receive(buffer)
            if size < 0:
                break
            datagram = buffer[:size]
            if size < HEADER.size or datagram[3] != PacketKind.DATA:
                self._pass_on(datagram)
                continue
            try:
                held = any(item.receiver.take_initial(datagram) for item in self.incoming)
            except Exception:
                self.faulty += 1
                continue
            self.before_start += not held
            found |= held
        return found

    def stop(self, tick: int, now: int, epoch: int) -> None:
        """Tell the peer that this side stops."""
        for _ in range(LAST_WORDS):
            self.outgoing.send_flagged(PacketFlag.STOPPING, tick, now, epoch)

    def _newest(self, stream: int) -> tuple[int, int]:
        known = stream < len(self.incoming)
        return self.incoming[stream].receiver.newest if known else (0, -1)

    def _fit(self) -> None:
        """Set from which age a packet is too old, from the lowest round trip of late."""
        trip = self._fitted = self._trips.lowest
        if trip is None:
            return
        ticks = math.ceil(trip / (self._tick * 1_000_000_000))
        for item in self.incoming:
            item.allow(ticks)
        self._round_trip_ticks = min(ticks, 2 * self._longest_way)

    def _unheard(self, tick: int) -> int:
        """For how long nothing new was acknowledged, beyond what the way there and back takes."""
        newest = self.outgoing.acknowledgements.newest
        since = newest if newest is not None else self.outgoing.first_sent
        if since is None:
            return 0
        return tick - since - self._round_trip_ticks - ACKNOWLEDGE_WITHIN * self._period

    def _guard(self, tick: int) -> None:
        """Have the kernel let in only what may be this session's next packet.

        A flood that starts between two packets of the peer takes the one tick's reads, and no more:
        copies of what was received before are below the floor, and a copy of what comes next can
        only come after it.
        """
        if self.session is None:
            return
        session = self.session.session
        floor = min((item.receiver.highest(session) for item in self.incoming), default=-1) + 1
        # A peer that is lost may come back with a new session.
        lost = not all(item.valid for item in self.incoming)
        self.intake.guard(tick, session, floor, handshakes=lost)

    def _pass_on(self, datagram: memoryview) -> None:
        size = len(datagram)
        if size < HEADER.size:
            if self.incoming:
                self.incoming[0].receiver.tally[Fate.TRUNCATED] += 1
            else:
                self.foreign += 1
        elif PacketKind.HELLO <= datagram[3] <= PacketKind.KEEP:
            self._forward(datagram, self.transport.arrival())
        else:
            self.foreign += 1

    def _take(self, datagram: memoryview, tick: int, arrived: int) -> None:
        stream = datagram[4] | datagram[5] << 8
        if stream >= len(self.incoming):
            self.foreign += 1
            return
        item = self.incoming[stream]
        receiver, overdue = item.receiver, item.receiver.overdue
        session = int.from_bytes(datagram[8:16], "little")
        if not receiver.knows(session):
            self._hear()
        if receiver.accept(datagram, tick) in _TELLING:
            self._heard_at = tick
            self._learn(receiver, arrived)
            if receiver.overdue != overdue:
                self._blame(item, arrived)

    def _learn(self, receiver: Receiver, arrived: int) -> None:
        """Take what an authentic packet says about the peer's clock and grid, and about the way."""
        sent, echo_sent, echo_received = receiver.last_times
        outgoing = self.outgoing
        if sent > outgoing.echo[0] or not any(outgoing.echo):
            outgoing.echo = (sent, arrived)
        if receiver.peer_epoch:
            self.peer_epoch = receiver.peer_epoch
        outgoing.heard(receiver.bundle.stream, *receiver.acknowledged)
        if echo_sent and self.clock.add(echo_sent, echo_received, sent, arrived):
            self._trips.add(self.clock.last_round_trip, arrived)

    def _blame(self, item: Incoming, arrived: int) -> None:
        """Of a packet that missed its sample, find out whether it was the way that took so long."""
        bundle, delay = item.receiver.bundle, item.receiver.settings.delay
        on_its_way = arrived + self.clock.offset(arrived) - item.receiver.last_times[0]
        if self.clock.ready and on_its_way > delay * bundle.period * bundle.tick * 1_000_000_000:
            item.overdue_by_network += 1
