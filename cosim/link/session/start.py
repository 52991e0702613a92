"""How stations agree on one start: clocks compared by KEEPs, then an instant of one clock.

The station whose name sorts first leads. A fresh start happens at tick 0 of a grid that the leader
lays; whoever meets a station that has a grid already joins that one, at a tick of its own network
period, so that no order of restarts makes two. Nothing here reads a clock or a socket.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from cosim.link.session.answerer import Answerer
from cosim.link.session.asker import Asker
from cosim.link.session.keys import SessionKeys
from cosim.link.session.live import Keep, LiveSession, SessionState
from cosim.link.wire.clock import ClockEstimate

KEEP_INTERVAL = 20_000_000
"""ns between two KEEPs while one of the two does not run yet."""
CALM_INTERVAL = 250_000_000
"""The same while both run: the asker's, which the answerer answers."""
EXCHANGES = 16
"""Clock exchanges that an estimate needs."""
LEAD = 1_000_000_000
"""ns between the decision and the start."""
WAIT_FOR_OTHERS = 2_000_000_000
"""ns that a station which joins a session waits for stations that do not answer."""

FURTHEST_START = 10_000_000_000
"""ns that a start may lie ahead; a peer that says more is not believed."""
LARGEST_TICK = 2**31 - 1
"""Session tick that a station may join at: ticks have to fit the models' 32-bit inputs."""

Side = Asker | Answerer


@dataclass(frozen=True, slots=True)
class Start:
    """When to begin: own clock (ns) at session tick 0, and the own first tick."""

    epoch: int
    first_tick: int


@dataclass(slots=True)
class _Other:
    side: Side
    clock: ClockEstimate
    session: LiveSession | None = None
    epoch: int = 0

    @property
    def state(self) -> SessionState:
        return SessionState.NONE if self.session is None else self.session.peer_state


class StartAgreement:
    """All pairs of one station: sessions, clocks, and the start that they agree on."""

    def __init__(
        self,
        *,
        own: str,
        sides: Mapping[str, Side],
        tick: Fraction,
        period: int,
        exchanges: int = EXCHANGES,
    ) -> None:
        self.own = own
        self.start: Start | None = None
        self.armed = True
        """Whether the own loop could begin; until then the others are not told to."""
        self.absurd = 0
        """Looks at a peer's grid that could not be true."""
        self._exchanges = exchanges
        self._tick_ns = tick * 1_000_000_000
        self._period = period
        self._epoch = 0
        self._running = False
        self._join_since: int | None = None
        self._others = {name: _Other(side, ClockEstimate()) for name, side in sides.items()}

    @property
    def leader(self) -> str:
        """The station whose clock the others follow."""
        return min(self.own, *self._others)

    def side(self, peer: str) -> Side:
        """The handshake with one peer."""
        return self._others[peer].side

    def clock(self, peer: str) -> ClockEstimate:
        """The estimate of one peer's clock."""
        return self._others[peer].clock

    def sessions(self) -> dict[str, SessionKeys]:
        """The present session of every peer that has one."""
        found = {name: other.session for name, other in self._others.items()}
        return {name: live.keys for name, live in found.items() if live is not None}

    def run_on(self, epoch: int) -> None:
        """The own loop runs, and its session tick 0 lies (or would lie) at ``epoch`` (ns)."""
        self._epoch = epoch
        self._running = True

    def poll(self, now: int) -> list[tuple[str, bytes]]:
        """What to send at ``now``: (peer, datagram)."""
        out: list[tuple[str, bytes]] = []
        for name, other in self._others.items():
            out += [(name, datagram) for datagram in other.side.poll(now)]
            live = other.session
            if live is None or live is not other.side.current:
                continue
            both = self._running and bool(live.peer_state & SessionState.RUNNING)
            if both and not other.side.asks:
                continue
            if live.is_due(now, CALM_INTERVAL if both else KEEP_INTERVAL):
                out.append((name, self._keep(live, now)))
        self._decide(now)
        return out

    def receive(
        self, peer: str, datagram: bytes, received: int, now: int, address: bytes = b""
    ) -> bytes | None:
        """Take a datagram that came at ``received`` (ns); what to answer, if anything."""
        other = self._others[peer]
        outcome = other.side.receive(datagram, received, now, address)
        self._adopt(other)
        if outcome.keep is None:
            return outcome.answer
        self._take(other, outcome.keep)
        self._decide(now)
        live = other.session
        # The asker alone keeps on asking; two that answered each other would never end.
        fresh = live is not None and live.last_sent is None
        if live is not None and not other.side.asks and (fresh or self._running):
            return self._keep(live, now)
        return outcome.answer

    def _adopt(self, other: _Other) -> None:
        """Go on under a session that has just been confirmed."""
        live = other.side.current
        if live is None or live is other.session:
            return
        # A peer that was restarted has another clock and knows no grid.
        if other.session is None or other.session.instance != live.instance:
            other.clock.forget()
            other.epoch = 0
        other.session = live

    def _take(self, other: _Other, keep: Keep) -> None:
        other.epoch = keep.epoch
        if keep.echo_sent:
            other.clock.add(keep.echo_sent, keep.echo_received, keep.sent, keep.received)
            other.clock.update(keep.received)

    def _keep(self, live: LiveSession, now: int) -> bytes:
        state = SessionState.READY if self._ready() else SessionState.NONE
        epoch = 0
        if self._running:
            state |= SessionState.RUNNING | SessionState.GRID
            epoch = self._epoch
        elif self.start is not None:
            state |= SessionState.GRID
            epoch = self.start.epoch
        return live.write(now, epoch, state)

    def _known(self, other: _Other) -> bool:
        return other.session is not None and other.clock.samples >= self._exchanges

    def _ready(self) -> bool:
        return self.armed and all(self._known(other) for other in self._others.values())

    def _decide(self, now: int) -> None:
        if self.start is not None or self._running or not self.armed:
            return
        with_grid = [
            other
            for _, other in sorted(self._others.items())
            if other.state & SessionState.GRID and self._known(other)
        ]
        if with_grid:
            self._join_since = self._join_since or now
            if self._ready() or now - self._join_since > WAIT_FOR_OTHERS:
                self._join(with_grid[0], now)
            return
        ready = self._ready() and all(o.state & SessionState.READY for o in self._others.values())
        if ready and self.own == self.leader:
            self.start = Start(now + LEAD, 0)

    def _join(self, other: _Other, now: int) -> None:
        epoch = other.epoch - other.clock.offset(now)
        running = other.state & SessionState.RUNNING
        past = now + (LEAD if running else 0) - epoch
        if not -FURTHEST_START <= past <= LARGEST_TICK * self._tick_ns:
            self.absurd += 1
            return
        # A start that is still to come is everybody's first tick.
        samples = Fraction(max(0, past)) / (self._tick_ns * self._period)
        self.start = Start(epoch, -(-samples.numerator // samples.denominator) * self._period)
