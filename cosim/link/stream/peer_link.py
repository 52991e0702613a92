"""One peer as the loop sees it: drained once a tick, released, weighed, answered at its samples.

The handshake is not in here: its datagrams are passed on to the process that does it, and new
session keys come back from there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from cosim.link.session.keys import SessionKeys
from cosim.link.stream.bundle import Bundle, FieldRole
from cosim.link.stream.clock import ClockEstimate
from cosim.link.stream.peer import PeerWeight
from cosim.link.stream.receiver import WAITING_SLOTS, Fate, Receiver, ReceiverSettings
from cosim.link.stream.settings import LinkSettings
from cosim.link.wire.packet import HEADER, DataWriter, Flag, Kind, Opener, Sealer
from cosim.link.wire.transport import LARGEST_READ, Transport

READS_PER_TICK = 32
GUARD_TIME = Fraction(1)
"""Seconds for which the kernel filters after a tick that had more to read than that."""
_TELLING = (Fate.ACCEPTED, Fate.LATE)
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
        sends: Sequence[Bundle],
        receives: Sequence[Bundle],
        settings: Sequence[LinkSettings],
        transport: Transport,
        forward: Callable[[memoryview, int], None],
    ) -> None:
        self.transport = transport
        self.clock = ClockEstimate()
        self.settings = tuple(settings)
        """One for each incoming stream."""
        self.incoming = [
            Incoming(
                Receiver(
                    bundle,
                    ReceiverSettings(
                        release=setting.release,
                        delay=setting.delay,
                        late_after=(setting.delay + setting.loss.hold_samples) * bundle.period,
                        # A station that was held up meets the others' packets early until it has
                        # caught up; they can wait.
                        early=WAITING_SLOTS // 2 * bundle.period,
                    ),
                ),
                PeerWeight(setting.loss, period=bundle.period, tick=bundle.tick),
            )
            for bundle, setting in zip(receives, settings, strict=True)
        ]
        self.outgoing = list(sends)
        self.writers = [DataWriter(None, bundle.stream, bundle.size) for bundle in sends]
        self.session: SessionKeys | None = None
        self.peer_epoch = 0
        """Where the peer's clock has session tick 0 on its present grid (ns); 0: not known yet."""
        self.foreign = 0
        """Datagrams of no known kind or stream."""
        self.flood = 0
        """Datagrams thrown away unread."""
        self.sent = 0
        self.before_arrival: Callable[[], None] | None = None
        """Called in a tick in which something has arrived, before that is looked at."""
        self._forward = forward
        self._buffer = memoryview(bytearray(LARGEST_READ))
        self._echo = (0, 0)
        self._guarded_until: int | None = None
        # What the loop looks at every tick is looked up once.
        self._roles = [
            (
                item.receiver.bundle.indices(FieldRole.SOURCE_AGE),
                item.receiver.bundle.indices(FieldRole.STATUS),
                item.receiver.bundle.indices(FieldRole.SOURCE_TICK),
            )
            for item in self.incoming
        ]

    def renew(self, keys: SessionKeys) -> None:
        """Begin under a session, or go on under a new one."""
        self.session = keys
        sealer = Sealer(keys.outgoing, keys.session)
        for writer in self.writers:
            writer.renew(sealer)
        for item in self.incoming:
            item.receiver.renew(Opener(keys.incoming, keys.session))
        self.clock.forget()
        self.peer_epoch = 0
        self._echo = (0, 0)
        self._let_everything_in()

    def allow(self, round_trip: int) -> None:
        """Set from which age a packet is too old, from the lowest round trip (ns).

        What a packet needs on this link is not late; what was kept back on the way for longer than
        the hold time is.
        """
        for item, setting in zip(self.incoming, self.settings, strict=True):
            bundle = item.receiver.bundle
            one_way = Fraction(round_trip, 2_000_000_000) / (bundle.tick * bundle.period)
            samples = max(setting.delay, 1 + one_way.__ceil__()) + setting.loss.hold_samples
            item.receiver.allow(late_after=samples * bundle.period)

    def drain(self, tick: int) -> None:
        """Read what has arrived: at most 32 datagrams, the rest thrown away and counted."""
        if self._guarded_until is not None and tick >= self._guarded_until:
            self._let_everything_in()
        buffer = self._buffer
        for count in range(READS_PER_TICK):
            size = self.transport.receive(buffer)
            if size < 0:
                return
            if count == 0 and self.before_arrival is not None:
                self.before_arrival()
            self._take(buffer[:size], tick)
        discarded = self.transport.discard()
        if discarded:
            self.flood += discarded
            self._guard(tick)

    def _guard(self, tick: int) -> None:
        """Have the kernel let in only what may be this session's next packet.

        A flood that starts between two packets of the peer takes the one tick's reads, and no more:
        copies of what was received before are below the floor, and a copy of what comes next can
        only come after it.
        """
        if self.session is None:
            return
        floor = min((item.receiver.highest for item in self.incoming), default=-1) + 1
        # A peer that is lost may come back with a new session.
        lost = not all(item.valid for item in self.incoming)
        self.transport.guard(self.session.session, floor, handshakes=lost)
        second = GUARD_TIME / self.incoming[0].receiver.bundle.tick if self.incoming else 0
        self._guarded_until = tick + round(second)

    def _let_everything_in(self) -> None:
        if self._guarded_until is not None:
            self._guarded_until = None
            self.transport.unguard()

    def _take(self, datagram: memoryview, tick: int) -> None:
        size = len(datagram)
        kind = datagram[3] if size >= HEADER.size else 0
        if kind == Kind.DATA:
            stream = datagram[4] | datagram[5] << 8
            if stream < len(self.incoming):
                item = self.incoming[stream]
                receiver, overdue = item.receiver, item.receiver.overdue
                if receiver.accept(datagram, tick) in _TELLING:
                    arrived = self._learn(receiver)
                    if receiver.overdue != overdue:
                        self._blame(item, arrived)
                return
        elif Kind.HELLO <= kind <= Kind.SYNC:
            self._forward(datagram, self.transport.arrival())
            return
        elif size < HEADER.size and self.incoming:
            self.incoming[0].receiver.tally[Fate.TRUNCATED] += 1
            return
        self.foreign += 1

    def _blame(self, item: Incoming, arrived: int) -> None:
        """Of a packet that missed its sample, find out whether it was the way that took so long."""
        bundle, delay = item.receiver.bundle, item.receiver.settings.delay
        on_its_way = arrived + self.clock.offset(arrived) - item.receiver.last_times[0]
        if self.clock.ready and on_its_way > delay * bundle.period * bundle.tick * 1_000_000_000:
            item.overdue_by_network += 1

    def _learn(self, receiver: Receiver) -> int:
        """Take what an authentic packet says about the peer's clock and grid; when it arrived."""
        arrived = self.transport.arrival()
        sent, echo_sent, echo_received = receiver.last_times
        self._echo = (sent, arrived)
        if receiver.peer_epoch:
            self.peer_epoch = receiver.peer_epoch
        if echo_sent:
            self.clock.add(echo_sent, echo_received, sent, arrived)
        return arrived

    def release(self, tick: int) -> None:
        """Show what is due at this tick and weigh the peer."""
        for number, item in enumerate(self.incoming):
            receiver = item.receiver
            item.fresh = receiver.release(tick)
            if item.fresh:
                self._inspect(number, item)
            age = tick - receiver.tick if receiver.tick >= 0 else tick
            item.age = max(0, age) + item.source_age
            active = item.active and not receiver.stopping and self.session is not None
            item.weight.update(fresh=item.fresh, source_age=item.source_age, active=active)
            # A source that is no longer active fades before it is declared invalid: an input that
            # switches a force off at once would be a jump on the hand.
            item.valid = item.weight.weight > 0.0

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
        item.source_age = age
        item.active = all(int(values[i]) & (ACTIVE | FAULT) == ACTIVE for i in statuses)

    def send(self, tick: int, now: int, epoch: int, *, flags: int = 0) -> None:
        """Send every bundle whose sample is due at ``tick``; fill ``writers[i].values`` before."""
        if self.session is None:
            return
        for bundle, writer in zip(self.outgoing, self.writers, strict=True):
            if tick % bundle.period == 0:
                self._seal(bundle, writer, (tick, now), epoch=epoch, flags=flags)
                self.sent += self.transport.send(writer.datagram)

    def send_initial(self, tick: int, now: int, epoch: int) -> None:
        """Before the start: send the values as they are at the first tick."""
        if self.session is None:
            return
        for bundle, writer in zip(self.outgoing, self.writers, strict=True):
            self._seal(bundle, writer, (tick, now), epoch=epoch, flags=Flag.INITIAL)
            self.sent += self.transport.send(writer.datagram)

    def take_initial(self) -> bool:
        """Before the start: hold what the peer has sent of its first tick, if it has."""
        found = False
        for _ in range(READS_PER_TICK):
            size = self.transport.receive(self._buffer)
            if size < 0:
                break
            datagram = self._buffer[:size]
            kind = datagram[3] if size >= HEADER.size else 0
            if Kind.HELLO <= kind <= Kind.SYNC:
                self._forward(datagram, self.transport.arrival())
            elif kind == Kind.DATA:
                found |= any(item.receiver.take_initial(datagram) for item in self.incoming)
        return found

    def stop(self, tick: int, now: int, epoch: int) -> None:
        """Tell the peer that this side stops: three copies, because one may be lost."""
        if self.session is None:
            return
        for _ in range(3):
            for bundle, writer in zip(self.outgoing, self.writers, strict=True):
                self._seal(bundle, writer, (tick, now), epoch=epoch, flags=Flag.STOPPING)
                self.sent += self.transport.send(writer.datagram)

    def _seal(
        self, bundle: Bundle, writer: DataWriter, at: tuple[int, int], *, epoch: int, flags: int
    ) -> None:
        known = bundle.stream < len(self.incoming)
        writer.seal(
            *at,
            echo_sent=self._echo[0],
            echo_received=self._echo[1],
            epoch=epoch,
            acknowledged=self.incoming[bundle.stream].receiver.highest if known else -1,
            flags=flags,
        )
