"""Whole stations in simulated time: handshake, start, loop and links, all that a process does.

What the real processes do with sockets, a heap of events does here; everything else is theirs.
"""

from __future__ import annotations

import heapq
import itertools
import random
import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from cosim.base.component import Causality, Setup, VariableType
from cosim.link.session.client import HandshakeProcess
from cosim.link.session.messages import ARMED, DATAGRAM, LIVE, STATUS
from cosim.link.session.negotiator import SessionNegotiator
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.phase import PhaseFollower
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.packet import PacketFlag, PacketKind
from tests.support.link.simulated import SkewedClock
from tests.support.link.world import ACTIVE_STATUS, bundle

MILLISECOND = 1_000_000
SECOND = 1_000_000_000
RATE, PERIOD = 128, 1
TICK_NS = SECOND / RATE
SEALED = {PacketKind.DATA, PacketKind.KEEP}


def position(name: str, true: float) -> float:
    """Where a station's hand is: 0.1 m to and fro, at most 0.9 m/s; every hand its own phase."""
    return 0.1 * float(np.sin(9.0 * true * 1e-9 + ord(name)))


class Wire:
    """Carries datagrams; ``treat`` says what becomes of each: (due, content) pairs."""

    def __init__(self, treat: Callable[[str, str, bytes, int], list[tuple[int, bytes]]]) -> None:
        self.treat = treat
        self.now = 0
        self.queue: list[tuple[int, int, str, str, bytes]] = []
        self.sealed: dict[tuple[str, bytes], bytes] = {}
        self._count = itertools.count()

    def send(self, source: str, target: str, datagram: bytes) -> None:
        if datagram[3] in SEALED:
            # A nonce is kind, stream and sequence; the session stands for the key.
            name = (source, datagram[:24])
            assert self.sealed.setdefault(name, datagram) is datagram, "a nonce was used twice"
        for due, content in self.treat(source, target, datagram, self.now):
            self.put(due, source, target, content)

    def put(self, due: int, source: str, target: str, content: bytes) -> None:
        heapq.heappush(self.queue, (due, next(self._count), source, target, content))


class _Pipe:
    """The loop's end of its socket pair."""

    def __init__(self, take: Callable[[bytes], None]) -> None:
        self.send = take

    def setblocking(self, flag: bool) -> None:
        """It never blocks."""


class _Transport:
    def __init__(self, station: Station, peer: str) -> None:
        self.station, self.peer = station, peer
        self.queue: deque[tuple[int, bytes]] = deque()
        self._arrival = 0

    def receive(self, buffer: memoryview) -> int:
        if not self.queue:
            return -1
        self._arrival, content = self.queue.popleft()
        size = min(len(content), len(buffer))
        buffer[:size] = content[:size]
        return size

    def arrival(self) -> int:
        return self._arrival

    def send(self, datagram) -> bool:
        self.station.wire.send(self.station.name, self.peer, bytes(datagram))
        return True

    def discard(self) -> int:
        count = len(self.queue)
        self.queue.clear()
        return count

    def guard(self, session: int, floor: int, *, handshakes: bool) -> None:
        """There is no kernel here."""

    def unguard(self) -> None:
        """There is no kernel here."""


@dataclass
class Sample:
    """What one tick showed of one peer."""

    true: int
    weight: float
    value: float
    sampled: int
    force: float


class Station:
    """One start of one station: from its first greeting until it is killed."""

    def __init__(
        self, name: str, others: list[str], wire: Wire, clock: SkewedClock, settings=None
    ) -> None:
        self.name, self.others, self.wire, self.clock = name, others, wire, clock
        self.settings = settings or LinkForm()
        self.alive = True
        self.live = False
        self.running = False
        self.stalled_until = 0
        self.origin = 0.0
        self.deadline = 0.0
        self.tick = 0
        self.samples: dict[str, list[Sample]] = {peer: [] for peer in others}
        self.negotiator = SessionNegotiator(
            {
                "own": name,
                "peers": others,
                "key_files": [None] * len(others),
                "contracts": [{"rate": RATE}] * len(others),
                "tick": str(Fraction(1, RATE)),
                "period": PERIOD,
            }
        )
        self.told: deque[bytes] = deque()
        self.process = HandshakeProcess(name, others)
        self.process._own = _Pipe(self._serve)
        self.process.hear = self._hear
        self.grid = Grid(tick_ns=TICK_NS)
        self.transports = {peer: _Transport(self, peer) for peer in others}
        leader = min(name, *others)
        self.remotes: dict[str, RemoteStation] = {}
        self.cells: dict[str, dict] = {}
        for number, peer in enumerate(others):
            link = PeerLink(
                sends=[bundle(name, peer, RATE, PERIOD)],
                receives=[bundle(peer, name, RATE, PERIOD)],
                settings=[self.settings],
                transport=self.transports[peer],
                forward=self.process.forward(number),
                hear=self.process.hear,
            )
            self.process.links.append(link)
            follows = peer == leader
            self.remotes[peer] = RemoteStation(
                link,
                grid=self.grid,
                now=self._now,
                follower=PhaseFollower() if follows else None,
            )
            self._prepare(peer)
        self._told_at = 0
        self._initial_at = -SECOND
        self.process._own.send(ARMED)

    def _prepare(self, peer: str) -> None:
        remote = self.remotes[peer]
        cells = {
            v.name: np.zeros(1, np.float64 if v.type is VariableType.FLOAT64 else np.int64)
            for v in remote.variables
        }
        ways = {
            way: {v.name: cells[v.name] for v in remote.variables if v.causality is way}
            for way in (Causality.INPUT, Causality.OUTPUT)
        }
        setup = Setup(name="remote", parameters={}, tick=(1, RATE), period=1, seed=0)
        remote.initialise(setup, ways[Causality.INPUT], ways[Causality.OUTPUT])
        self.cells[peer] = cells

    def _now(self) -> int:
        return self.clock.at(self.wire.now)

    # The handshake process.

    def _serve(self, message: bytes) -> None:
        if message == ARMED:
            self.negotiator.agreement.armed = True
        elif message == LIVE:
            self.live = True
        elif message[:1] == b"D":
            _, number, arrived = DATAGRAM.unpack_from(message)
            self.serve_datagram(number, message[DATAGRAM.size :], arrived)
        elif message[:1] == b"S":
            _, epoch = STATUS.unpack_from(message)
            self.negotiator.agreement.run_on(epoch)
            alive = struct.unpack_from(f"<{len(self.others)}Q", message, STATUS.size)
            self.negotiator.hear_of(alive, self._now())

    def serve_datagram(self, number: int, datagram: bytes, arrived: int) -> None:
        if len(datagram) < 24 or datagram[3] < PacketKind.HELLO:
            return
        peer = self.others[number]
        answer = self.negotiator.agreement.receive(peer, datagram, arrived, self._now())
        self.told.extend(self.negotiator.news())
        if answer is not None:
            self.wire.send(self.name, peer, answer)

    def step_process(self) -> None:
        due = self.negotiator.agreement.poll(self._now())
        self.told.extend(self.negotiator.news())
        for peer, datagram in due:
            self.wire.send(self.name, peer, datagram)

    def _hear(self, say=None) -> None:
        self.process._forwarded = 0
        while self.told:
            self.process._take(self.told.popleft(), say)

    # The network.

    def arrive(self, source: str, content: bytes) -> None:
        if self.live:
            self.transports[source].queue.append((self._now(), content))
        else:
            self.serve_datagram(self.others.index(source), content, self._now())

    # The loop.

    def wait(self) -> None:
        """Before the first tick: look whether the start is agreed on, then send first values."""
        self._hear(lambda _: None)
        start = self.process.start
        if start is None:
            return
        now = self._now()
        if not self.live:
            self.process._own.send(LIVE)
            self.grid.first_tick = start.first_tick
            self.origin = start.epoch + start.first_tick * TICK_NS
        if now < self.origin - 5 * MILLISECOND:
            if now - self._initial_at >= 20 * MILLISECOND:
                self._initial_at = now
                for peer, remote in self.remotes.items():
                    self._fill(peer)
                    remote.collect()
                    remote.link.outgoing.send_flagged(
                        PacketFlag.INITIAL, self.grid.first_tick, now, start.epoch
                    )
                    if remote.link.take_initial():
                        remote.show_initial()
            return
        if now > self.origin:
            past = (now + 5 * MILLISECOND - start.epoch) / TICK_NS
            self.grid.first_tick = int(np.ceil(past))
            self.origin = start.epoch + self.grid.first_tick * TICK_NS
        self.running = True
        self.deadline = self.origin

    def _fill(self, peer: str) -> None:
        cells = self.cells[peer]
        session_tick = self.tick + self.grid.first_tick
        own = (position(self.name, self.wire.now), session_tick, 0, ACTIVE_STATUS)
        for member, value in zip(
            ("position", "source_tick", "source_age", "status"), own, strict=True
        ):
            cells[f"vr_{self.name}.{member}"][0] = value

    def run_tick(self) -> None:
        now = self._now()
        session_tick = self.tick + self.grid.first_tick
        self.grid.at_deadline(session_tick, round(self.deadline))
        for peer, remote in self.remotes.items():
            remote.read(self.tick)
            self._fill(peer)
            remote.write(self.tick)
            cells = self.cells[peer]
            value = float(cells[f"vr_{peer}.position"][0])
            weight = float(cells["lan.weight"][0])
            receiver = remote.link.incoming[0].receiver
            force = weight * (value - position(self.name, self.wire.now))
            sample = Sample(self.wire.now, weight, value, receiver.tick, force)
            self.samples[peer].append(sample)
        if self.tick % 4 == 0:
            self._hear()
            if now - self._told_at > 250 * MILLISECOND:
                self._told_at = now
                alive = [r.link.alive(session_tick) for r in self.remotes.values()]
                self.process.tell(self.grid.epoch, alive)
        self.tick += 1
        step = TICK_NS * (1.0 + self.grid.slew)
        # After a stall ticks follow each other sooner until the grid is caught up with.
        self.deadline += step
        if now - self.deadline > step:
            self.stalled_until = max(self.stalled_until, self.wire.now + round(0.6 * step))


@dataclass
class World:
    """Stations by name, killed and started again at will, over one wire."""

    wire: Wire
    names: list[str]
    clocks: dict[str, SkewedClock] = field(default_factory=dict)
    stations: dict[str, Station] = field(default_factory=dict)
    past: list[Station] = field(default_factory=list)
    settings: LinkForm | None = None

    def start(self, name: str) -> Station:
        others = [other for other in self.names if other != name]
        draw = random.Random((name, len(self.past)).__repr__())
        # A restarted machine has another clock.
        clock = SkewedClock(draw.randrange(10**15), draw.uniform(-4e-5, 4e-5))
        self.stations[name] = Station(name, others, self.wire, clock, self.settings)
        return self.stations[name]

    def kill(self, name: str) -> None:
        station = self.stations.pop(name, None)
        if station is not None:
            self.past.append(station)

    @property
    def everybody(self) -> list[Station]:
        return [*self.past, *self.stations.values()]

    def run(self, until: int, events: list[tuple[int, Callable[[], None]]] | None = None) -> None:
        """Run to a true time; ``events`` are (true time, what happens)."""
        wire = self.wire
        planned = sorted(events or [], key=lambda event: event[0])
        next_step = wire.now
        while True:
            ticks = [
                (max(s.clock.true(round(s.deadline)), s.stalled_until), s.name)
                for s in self.stations.values()
                if s.running
            ]
            choices = [(next_step, 2)]
            if ticks:
                choices.append((min(ticks)[0], 1))
            if wire.queue:
                choices.append((wire.queue[0][0], 0))
            if planned:
                choices.append((planned[0][0], -1))
            at, what = min(choices)
            if at >= until:
                wire.now = until
                return
            wire.now = max(wire.now, at)
            if what == -1:
                planned.pop(0)[1]()
                next_step = wire.now
            elif what == 0:
                _, _, source, target, content = heapq.heappop(wire.queue)
                there = self.stations.get(target)
                if there is not None:
                    there.arrive(source, content)
            elif what == 1:
                self.stations[min(ticks)[1]].run_tick()
            else:
                calm = all(station.running for station in self.stations.values())
                next_step = wire.now + (20 if calm else 4) * MILLISECOND
                for station in list(self.stations.values()):
                    station.step_process()
                    if not station.running:
                        station.wait()

    def agreed(self) -> bool:
        """Whether every pair sends and reads under one session."""
        for name, station in self.stations.items():
            for peer in station.others:
                if peer not in self.stations:
                    return False
                mine = station.remotes[peer].link.session
                theirs = self.stations[peer].remotes[name].link.session
                if mine is None or theirs is None or mine.session != theirs.session:
                    return False
        return len(self.stations) == len(self.names)

    def weights(self) -> list[float]:
        """Of every ordered pair, the weight of the last tick."""
        return [
            samples[-1].weight if samples else 0.0
            for station in self.stations.values()
            for samples in station.samples.values()
        ]
