"""How stations agree on one start: sealed clock exchanges, then an instant of the leader's clock.

The station whose name sorts first leads. A fresh start happens at tick 0 of a grid that the leader
lays; a station that comes back joins the grid of one that is running, at a tick of its own network
period. Nothing here reads a clock or a socket.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag
from fractions import Fraction

from cosim.link.session.handshake import Handshake
from cosim.link.session.keys import SessionKeys
from cosim.link.stream.clock import ClockEstimate
from cosim.link.wire.packet import HEADER, MAGIC, TAG_SIZE, VERSION, Kind, Opener, Sealer

_BODY = struct.Struct("<qqqqII")
"""sent, echo_sent, echo_received, epoch (ns, sender's clock), state, zero."""
SYNC_SIZE = HEADER.size + _BODY.size + TAG_SIZE
SYNC_INTERVAL = 20_000_000
SYNC_EXCHANGES = 16
LEAD = 1_000_000_000
"""ns between the decision and the start."""
WAIT_FOR_OTHERS = 2_000_000_000
"""ns that a station which joins a running session waits for stations that do not answer."""


class State(IntFlag):
    """What a station tells about itself."""

    NONE = 0
    READY = 1
    """It has a session and a clock estimate with every peer."""
    GRID = 2
    """``epoch`` is where session tick 0 lies."""
    RUNNING = 4


@dataclass(frozen=True, slots=True)
class Start:
    """When to begin: own clock (ns) at session tick 0, and the own first tick."""

    epoch: int
    first_tick: int


@dataclass(slots=True)
class _Guest:
    handshake: Handshake
    clock: ClockEstimate
    keys: SessionKeys | None = None
    sealer: Sealer | None = None
    opener: Opener | None = None
    highest: int = -1
    state: State = State.NONE
    epoch: int = 0
    echo: tuple[int, int] = (0, 0)
    last_sent: int | None = None


class Meeting:
    """All pairs of one station: sessions, clocks, and the start that they agree on."""

    def __init__(
        self,
        *,
        own: str,
        handshakes: Mapping[str, Handshake],
        tick: Fraction,
        period: int,
        clocks: Mapping[str, ClockEstimate] | None = None,
    ) -> None:
        self.own = own
        self.start: Start | None = None
        self.armed = True
        """Whether the own loop could begin; until then the others are not told to."""
        self.dropped = 0
        """SYNC messages that were forged, replayed or of no session."""
        self._tick_ns = tick * 1_000_000_000
        self._period = period
        self._epoch = 0
        self._running = False
        self._join_since: int | None = None
        self._guests = {
            name: _Guest(handshake, (clocks or {}).get(name, ClockEstimate()))
            for name, handshake in handshakes.items()
        }

    @property
    def leader(self) -> str:
        """The station whose clock the others follow."""
        return min(self.own, *self._guests)

    def clock(self, peer: str) -> ClockEstimate:
        """The estimate of one peer's clock."""
        return self._guests[peer].clock

    def sessions(self) -> dict[str, SessionKeys]:
        """The confirmed session of every peer that has one."""
        return {name: guest.keys for name, guest in self._guests.items() if guest.keys is not None}

    def run_on(self, epoch: int) -> None:
        """The own loop runs, and its session tick 0 lies (or would lie) at ``epoch`` (ns)."""
        self._epoch = epoch
        self._running = True

    def poll(self, now: int) -> list[tuple[str, bytes]]:
        """What to send at ``now``: (peer, datagram)."""
        out: list[tuple[str, bytes]] = []
        for name, guest in self._guests.items():
            asked = guest.handshake.poll(now)
            if asked is not None:
                out.append((name, asked))
            self._adopt(guest)
            due = guest.last_sent is None or now - guest.last_sent >= SYNC_INTERVAL
            if guest.sealer is not None and due and not self._running:
                out.append((name, self._sync(guest, now)))
        self._decide(now)
        return out

    def receive(self, peer: str, datagram: bytes, received: int, now: int) -> bytes | None:
        """Take a datagram that came at ``received`` (ns); what to answer, if anything."""
        guest = self._guests[peer]
        if len(datagram) != SYNC_SIZE or datagram[3] != Kind.SYNC:
            answer = guest.handshake.receive(datagram, now)
            self._adopt(guest)
            return answer
        if not self._take_sync(guest, datagram, received):
            self.dropped += 1
            return None
        self._decide(now)
        # Two that both run would answer each other for ever.
        if self._running and not guest.state & State.RUNNING:
            return self._sync(guest, now)
        return None

    def _adopt(self, guest: _Guest) -> None:
        """Go on under a session that the handshake has just confirmed."""
        keys = guest.handshake.session
        if keys is None or (guest.keys is not None and guest.keys.session == keys.session):
            return
        guest.keys = keys
        guest.sealer = Sealer(keys.outgoing, keys.session)
        guest.opener = Opener(keys.incoming, keys.session)
        guest.highest = -1
        guest.state = State.NONE
        guest.echo = (0, 0)
        guest.clock.forget()

    def _take_sync(self, guest: _Guest, datagram: bytes, received: int) -> bool:
        magic, version, _, stream, zero, session, sequence = HEADER.unpack_from(datagram)
        opener = guest.opener
        if opener is None or (magic, version, stream, zero) != (MAGIC, VERSION, 0, 0):
            return False
        if session != opener.session or sequence <= guest.highest:
            return False
        plain = bytearray(_BODY.size)
        if not opener.open(memoryview(datagram), memoryview(plain)):
            return False
        guest.highest = sequence
        sent, echo_sent, echo_received, epoch, state, _ = _BODY.unpack(plain)
        guest.echo = (sent, received)
        guest.state = State(state & 7)
        guest.epoch = epoch
        if echo_sent:
            guest.clock.add(echo_sent, echo_received, sent, received)
            guest.clock.update(received)
        return True

    def _sync(self, guest: _Guest, now: int) -> bytes:
        assert guest.sealer is not None
        guest.last_sent = now
        state = State.READY if self._ready() else State.NONE
        epoch = 0
        if self._running:
            state |= State.RUNNING | State.GRID
            epoch = self._epoch
        elif self.start is not None:
            state |= State.GRID
            epoch = self.start.epoch
        plain = _BODY.pack(now, *guest.echo, epoch, state, 0)
        datagram = bytearray(SYNC_SIZE)
        guest.sealer.seal(Kind.SYNC, 0, memoryview(plain), memoryview(datagram))
        return bytes(datagram)

    def _ready(self) -> bool:
        return self.armed and all(self._known(guest) for guest in self._guests.values())

    @staticmethod
    def _known(guest: _Guest) -> bool:
        return guest.handshake.settled and guest.clock.samples >= SYNC_EXCHANGES

    def _decide(self, now: int) -> None:
        if self.start is not None or self._running or not self.armed:
            return
        running = [
            guest
            for _, guest in sorted(self._guests.items())
            if guest.state & State.RUNNING and self._known(guest)
        ]
        if running:
            self._join_since = self._join_since or now
            if self._ready() or now - self._join_since > WAIT_FOR_OTHERS:
                self._join(running[0], now)
            return
        if not self._ready():
            return
        if self.own == self.leader:
            if all(guest.state & State.READY for guest in self._guests.values()):
                self.start = Start(now + LEAD, 0)
            return
        leader = self._guests[self.leader]
        if leader.state & State.GRID:
            self.start = Start(leader.epoch - leader.clock.offset(now), 0)

    def _join(self, guest: _Guest, now: int) -> None:
        epoch = guest.epoch - guest.clock.offset(now)
        samples = Fraction(now + LEAD - epoch) / (self._tick_ns * self._period)
        self.start = Start(epoch, -(-samples.numerator // samples.denominator) * self._period)
