"""One peer as the loop sees it: drained once a tick, released, weighed, answered at its samples.

The handshake is not in here: its datagrams are passed on to the process that does it, and new
session keys come back from there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from cosim.link.session.keys import SessionKeys
from cosim.link.stream.admission import Admission, PacketJudge
from cosim.link.stream.bundle import FieldRole, PacketBundle
from cosim.link.stream.clock import ClockEstimate
from cosim.link.stream.form import LinkForm
from cosim.link.stream.path import Acknowledgements, RoundTrips
from cosim.link.stream.peer import PeerState, PeerWeight, Reason
from cosim.link.stream.receiver import WAITING_SLOTS, Fate, Receiver, ReceiverSettings, Release
from cosim.link.wire.packet import HEADER, DataWriter, Opener, PacketFlag, PacketKind, Sealer
from cosim.link.wire.transport import LARGEST_READ, Transport

READ_AHEAD = Fraction(1, 2)
"""Seconds of packets that one tick reads: what a radio that slept hands over at once."""
LEAST_READS, MOST_READS = 32, 256
GUARD_TIME = Fraction(1)
"""Seconds for which the kernel filters after a tick that had more to read than that."""
LIFE = Fraction(1, 4)
"""Seconds within which a live session has been heard and acknowledged."""
ACKNOWLEDGE_WITHIN = 4
"""Samples beyond the round trip: two until the acknowledgement is sent, two for lost ones."""
LARGEST_AGE = 2**31 - 1
"""Ages and ticks are shown no larger: models take them as 32-bit integers."""
_TELLING = (Fate.ACCEPTED, Fate.LATE, Fate.REORDERED, Fate.OUT_OF_RANGE, Fate.JUMP)
ACTIVE = 2
FAULT = 4
"""Bits of a status field (docs/protocol.md)."""


@dataclass(slots=True)
class Incoming:
    """A stream that comes from the peer, with what is made of it at each tick."""

    receiver: Receiver
    weight: PeerWeight
    age: int = 0
    """Base ticks since the held values were measured: the packet's age and the source's own."""
    valid: bool = False
    fresh: bool = False
    source_age: int = 0
    active: bool = True
    source_tick: float = -1.0
    overdue_by_network: int = 0
    """Packets that missed their sample because of the time on the way; the others were sent late,
    by a station that had been held up."""
    source_changed: int = 0
    """Session tick of the packet in which the source's own tick last changed."""


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
        """``forward`` takes what is not a value and when it came, to pass it on.

        ``hear`` is called when a session is not known yet: its keys may be waiting. ``judge`` makes
        what looks at the values of a stream.
        """
        self.transport = transport
        self.clock = ClockEstimate()
        self.settings = tuple(settings)
        """One for each incoming stream."""
        self.incoming = [
            _incoming(bundle, setting, judge(bundle))
            for bundle, setting in zip(receives, settings, strict=True)
        ]
        self.outgoing = list(sends)
        self.writers = [DataWriter(None, bundle.stream, bundle.size) for bundle in sends]
        self.session: SessionKeys | None = None
        """What is sent under."""
        self.peer_epoch = 0
        """Where the peer's clock has session tick 0 on its present grid (ns); 0: not known yet."""
        self.foreign = 0
        """Datagrams of no known kind or stream."""
        self.flood = 0
        """Datagrams thrown away unread."""
        self.faulty = 0
        """Datagrams that the receive path could not cope with; always 0 unless it has an error."""
        self.sent = 0
        self.before_arrival: Callable[[], None] | None = None
        """Called in a tick in which something has arrived, before that is looked at."""
        self._forward, self._hear = forward, hear
        bundles = (*receives, *sends)
        self._tick = bundles[0].tick if bundles else Fraction(1)
        self._period = max((bundle.period for bundle in bundles), default=1)
        rate = sum(1 / (bundle.tick * bundle.period) for bundle in receives)
        self.reads = min(max(LEAST_READS, math.ceil(rate * READ_AHEAD)), MOST_READS)
        """Datagrams that a tick reads at most."""
        self._buffers = [memoryview(bytearray(LARGEST_READ)) for _ in range(self.reads)]
        self._offered: dict[int, SessionKeys] = {}
        self._echo = (0, 0)
        self._guarded_until: int | None = None
        self._trips = RoundTrips()
        self._fitted: int | None = None
        self._acks = Acknowledgements()
        self._first_sent: int | None = None
        self._round_trip_ticks = 2 * max((self._most(n) for n in range(len(receives))), default=0)
        self._heard_at = 0
        # What the loop looks at every tick is looked up once.
        self._roles = [
            (
                item.receiver.bundle.indices(FieldRole.SOURCE_AGE),
                item.receiver.bundle.indices(FieldRole.STATUS),
                item.receiver.bundle.indices(FieldRole.SOURCE_TICK),
            )
            for item in self.incoming
        ]

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
            self._echo = (0, 0)
        self._let_everything_in()

    def use(self, session: int) -> bool:
        """Send under a session that was offered; whether it is a new one.

        A session is begun once: its sequences never start again.
        """
        keys = self._offered.pop(session, None)
        if keys is None:
            return False
        self.session = keys
        self._acks.begin(session)
        sealer = Sealer(keys.outgoing, keys.session)
        for writer in self.writers:
            writer.renew(sealer)
        self._let_everything_in()
        return True

    def expect(self, round_trip: int, incoming: int) -> None:
        """Before the start: what the clock exchanges have measured (ns).

        ``round_trip`` is the lowest one, ``incoming`` the time that nine packets of ten need from
        the peer to here; a stream with ``delay: auto`` waits that long, in whole samples.
        """
        self._trips.preset(round_trip)
        for number, item in enumerate(self.incoming):
            receiver = item.receiver
            if self.settings[number].delay == "auto" and receiver.sequence < 0:
                sample = receiver.bundle.tick * receiver.bundle.period * 1_000_000_000
                delay = max(1, math.ceil(incoming / sample))
                most = self._most(number) // receiver.bundle.period
                receiver.settings = replace(receiver.settings, delay=min(delay, most))
        self._fit()

    def _most(self, number: int) -> int:
        """The longest path (base ticks) that a stream may take."""
        bundle = self.incoming[number].receiver.bundle
        return self.settings[number].longest_delay * bundle.period

    def _fit(self) -> None:
        """Set from which age a packet is too old, from the lowest round trip of late.

        What a packet needs on this link is not late, as long as the theory allows it; what was kept
        back on the way for longer than the hold time is.
        """
        trip = self._fitted = self._trips.lowest
        if trip is None:
            return
        ticks = math.ceil(trip / (self._tick * 1_000_000_000))
        most = 0
        for number, item in enumerate(self.incoming):
            receiver, weight = item.receiver, item.weight
            period = receiver.bundle.period
            path = max(receiver.settings.delay * period, ticks)
            late_after = min(path, self._most(number)) + weight.hold
            receiver.allow(late_after=late_after)
            weight.first_within = late_after + 2 * period
            most = max(most, self._most(number))
        self._round_trip_ticks = min(ticks, 2 * most)

    def drain(self, tick: int) -> None:
        """Read what has arrived, newest first; beyond a limit it is thrown away and counted."""
        if self._guarded_until is not None and tick >= self._guarded_until:
            self._let_everything_in()
        values: list[tuple[int, int, int, int]] = []
        receive, buffers = self.transport.receive, self._buffers
        count = 0
        while count < self.reads:
            size = receive(buffers[count])
            if size < 0:
                break
            if count == 0 and self.before_arrival is not None:
                self.before_arrival()
            datagram = buffers[count][:size]
            if size >= HEADER.size and datagram[3] == PacketKind.DATA:
                sequence = HEADER.unpack_from(datagram)[6]
                values.append((sequence, count, size, self.transport.arrival()))
            else:
                self._pass_on(datagram)
            count += 1
        if len(values) > 1:
            values.sort(reverse=True)
        for _, place, size, arrived in values:
            self._guarded(buffers[place][:size], tick, arrived)
        if self._trips.lowest != self._fitted:
            self._fit()
        if count == self.reads:
            discarded = self.transport.discard()
            if discarded:
                self.flood += discarded
                self._guard(tick)

    def _guarded(self, datagram: memoryview, tick: int, arrived: int) -> None:
        """Nothing that comes from outside may end the loop."""
        try:
            self._take(datagram, tick, arrived)
        except Exception:
            self.faulty += 1

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
        self.transport.guard(session, floor, handshakes=lost)
        self._guarded_until = tick + round(GUARD_TIME / self._tick)

    def _let_everything_in(self) -> None:
        if self._guarded_until is not None:
            self._guarded_until = None
            self.transport.unguard()

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

    def _blame(self, item: Incoming, arrived: int) -> None:
        """Of a packet that missed its sample, find out whether it was the way that took so long."""
        bundle, delay = item.receiver.bundle, item.receiver.settings.delay
        on_its_way = arrived + self.clock.offset(arrived) - item.receiver.last_times[0]
        if self.clock.ready and on_its_way > delay * bundle.period * bundle.tick * 1_000_000_000:
            item.overdue_by_network += 1

    def _learn(self, receiver: Receiver, arrived: int) -> None:
        """Take what an authentic packet says about the peer's clock and grid, and about the way."""
        sent, echo_sent, echo_received = receiver.last_times
        if sent > self._echo[0] or not any(self._echo):
            self._echo = (sent, arrived)
        if receiver.peer_epoch:
            self.peer_epoch = receiver.peer_epoch
        if receiver is self.incoming[0].receiver:
            self._acks.heard(*receiver.acknowledged)
        if echo_sent and self.clock.add(echo_sent, echo_received, sent, arrived):
            self._trips.add(self.clock.last_round_trip, arrived)

    def release(self, tick: int) -> None:
        """Show what is due at this tick and weigh the peer."""
        unheard = self._unheard(tick)
        for number, item in enumerate(self.incoming):
            receiver, weight = item.receiver, item.weight
            item.fresh = receiver.release(tick)
            if item.fresh:
                self._inspect(number, item)
            age = tick - receiver.tick if receiver.tick >= 0 else tick
            item.age = min(max(0, age) + item.source_age, LARGEST_AGE)
            late = receiver.last_late >= 0 and tick - receiver.last_late <= weight.hold
            weight.update(
                fresh=item.fresh,
                source_age=item.source_age,
                active=item.active and not receiver.stopping and self.session is not None,
                unheard=unheard,
                late=late,
            )
            receiver.held = weight.state is PeerState.FADING
            # A source that is no longer active fades before it is declared invalid: an input that
            # switches a force off at once would be a jump on the hand.
            item.valid = weight.weight > 0.0

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
        if self.session is None or not self.incoming or not self.outgoing:
            return 0
        recent = LIFE / self._tick
        heard = self._heard_at > 0 and tick - self._heard_at <= recent
        return self.session.session if heard and self._unheard(tick) <= recent else 0

    def _unheard(self, tick: int) -> int:
        """For how long nothing new was acknowledged, beyond what the way there and back takes."""
        since = self._acks.newest if self._acks.newest is not None else self._first_sent
        if since is None:
            return 0
        return tick - since - self._round_trip_ticks - ACKNOWLEDGE_WITHIN * self._period

    def _inspect(self, number: int, item: Incoming) -> None:
        """Of newly released values, find the source's age and whether it is active."""
        values = item.receiver.values.tolist()
        ages, statuses, ticks = self._roles[number]
        age = max([int(values[index]) for index in ages], default=0)
        for index in ticks:
            # A source that stands still is as old as its last change, whatever it says itself.
            if values[index] != item.source_tick:
                item.source_tick = values[index]
                item.source_changed = item.receiver.tick
            age = max(age, item.receiver.tick - item.source_changed)
        item.source_age = min(age, LARGEST_AGE)
        item.active = all(int(values[i]) & (ACTIVE | FAULT) == ACTIVE for i in statuses)

    def send(self, tick: int, now: int, epoch: int, *, flags: int = 0) -> None:
        """Send every bundle whose sample is due at ``tick``; fill ``writers[i].values`` before."""
        if self.session is None:
            return
        for bundle, writer in zip(self.outgoing, self.writers, strict=True):
            if tick % bundle.period == 0:
                self._seal(bundle, writer, (tick, now), epoch=epoch, flags=flags)
                self.sent += self.transport.send(writer.datagram)
        if self._first_sent is None:
            self._first_sent = tick

    def send_initial(self, tick: int, now: int, epoch: int) -> None:
        """Before the start: send the values as they are at the first tick."""
        if self.session is None:
            return
        for bundle, writer in zip(self.outgoing, self.writers, strict=True):
            self._seal(bundle, writer, (tick, now), epoch=epoch, flags=PacketFlag.INITIAL)
            self.sent += self.transport.send(writer.datagram)

    def take_initial(self) -> bool:
        """Before the start: hold what the peer has sent of its first tick, if it has."""
        found = False
        for _ in range(self.reads):
            size = self.transport.receive(self._buffers[0])
            if size < 0:
                break
            datagram = self._buffers[0][:size]
            if size < HEADER.size or datagram[3] != PacketKind.DATA:
                self._pass_on(datagram)
                continue
            try:
                found |= any(item.receiver.take_initial(datagram) for item in self.incoming)
            except Exception:
                self.faulty += 1
        return found

    def stop(self, tick: int, now: int, epoch: int) -> None:
        """Tell the peer that this side stops: three copies, because one may be lost."""
        if self.session is None:
            return
        for _ in range(3):
            for bundle, writer in zip(self.outgoing, self.writers, strict=True):
                self._seal(bundle, writer, (tick, now), epoch=epoch, flags=PacketFlag.STOPPING)
                self.sent += self.transport.send(writer.datagram)

    def _seal(
        self,
        bundle: PacketBundle,
        writer: DataWriter,
        at: tuple[int, int],
        *,
        epoch: int,
        flags: int,
    ) -> None:
        assert self.session is not None
        session, stream = self.session.session, bundle.stream
        known = stream < len(self.incoming)
        sequence = writer.seal(
            *at,
            echo_sent=self._echo[0],
            echo_received=self._echo[1],
            epoch=epoch,
            acknowledged=self.incoming[stream].receiver.newest if known else (0, -1),
            flags=flags,
        )
        if stream == 0:
            self._acks.sent(session, sequence, at[0])


def _incoming(bundle: PacketBundle, setting: LinkForm, judge: PacketJudge) -> Incoming:
    weight = PeerWeight(setting, period=bundle.period, tick=bundle.tick)
    delay = setting.least_delay
    receiver = Receiver(
        bundle,
        ReceiverSettings(
            release=Release(setting.release),
            delay=delay,
            late_after=delay * bundle.period + weight.hold,
            # A station that was held up meets the others' packets early until it has caught up;
            # they can wait.
            early=WAITING_SLOTS // 2 * bundle.period,
        ),
        judge,
    )
    return Incoming(receiver, weight)
