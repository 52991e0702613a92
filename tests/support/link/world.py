"""Two or more remote-station components in simulated time, with pacers on skewed clocks."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from cosim.base.component import Causality, Setup, VariableType
from cosim.link.stream.bundle import Field, FieldRole, PacketBundle
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.phase import PhaseFollower
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.transport import Transport
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.support import both_ends

ACTIVE_STATUS = 1 | 2 | 8


class SimulatedTransport:
    def __init__(self, network: Network, own: str, peer: str, clock: SkewedClock) -> None:
        self.network, self.own, self.peer, self.clock = network, own, peer, clock
        self.queue: deque[tuple[int, bytes]] = deque()
        self._arrival = 0

    def receive(self, buffer: memoryview) -> int:
        if not self.queue:
            return -1
        due, content = self.queue.popleft()
        self._arrival = self.clock.at(due)
        size = min(len(content), len(buffer))
        buffer[:size] = content[:size]
        return size

    def arrival(self) -> int:
        return self._arrival

    def send(self, datagram) -> bool:
        self.network.send(self.own, self.peer, bytes(datagram))
        return True

    def discard(self) -> int:
        count = len(self.queue)
        self.queue.clear()
        return count

    def guard(self, session: int, floor: int, *, handshakes: bool) -> None:
        """There is no kernel here."""

    def unguard(self) -> None:
        """There is no kernel here."""


def bundle(source: str, target: str, rate: int, period: int) -> PacketBundle:
    return PacketBundle(
        source=source,
        target=target,
        channel="lan",
        fields=(
            Field(name=f"vr_{source}.position", unit="m", minimum=-1.0, maximum=1.0, speed=5.0),
            Field(name=f"vr_{source}.source_tick", integer=True, role=FieldRole.SOURCE_TICK),
            Field(name=f"vr_{source}.source_age", integer=True, role=FieldRole.SOURCE_AGE),
            Field(name=f"vr_{source}.status", integer=True, role=FieldRole.STATUS),
        ),
        period=period,
        tick=Fraction(1, rate),
    )


@dataclass
class SimulatedStation:
    """One station's loop around its remote-station component."""

    name: str
    peer: str
    network: Network | None
    clock: SkewedClock
    rate: int = 1024
    period: int = 8
    settings: LinkForm = field(default_factory=LinkForm)
    source: Callable[[int], tuple[float, int, int, int]] = lambda tick: (
        0.0,
        tick,
        0,
        ACTIVE_STATUS,
    )
    """Session tick -> position, source tick, source age, status."""
    watch: Callable[[SimulatedStation, int], None] | None = None
    first_tick: int = 0
    alive: bool = True
    transport: Transport | None = None
    """One of the simulated network where none is given."""

    def __post_init__(self) -> None:
        self.now = 0
        self.forwarded: list[bytes] = []
        if self.transport is None:
            self.transport = SimulatedTransport(self.network, self.name, self.peer, self.clock)
        self.link = PeerLink(
            sends=[bundle(self.name, self.peer, self.rate, self.period)],
            receives=[bundle(self.peer, self.name, self.rate, self.period)],
            settings=[self.settings],
            transport=self.transport,
            forward=lambda datagram, at: self.forwarded.append(bytes(datagram)),
        )
        self.tick_ns = 1e9 / self.rate
        self.grid = Grid(tick_ns=self.tick_ns, first_tick=self.first_tick)
        follows = self.name > self.peer and self.settings.clock == "follow"
        self.remote = RemoteStation(
            self.link,
            grid=self.grid,
            now=lambda: self.now,
            follower=PhaseFollower() if follows else None,
        )
        views = {
            variable.name: np.zeros(
                variable.shape or (1,),
                dtype=np.float64 if variable.type is VariableType.FLOAT64 else np.int64,
            )
            for variable in self.remote.variables
        }
        causality = {variable.name: variable.causality for variable in self.remote.variables}
        self.inputs = {n: v for n, v in views.items() if causality[n] is Causality.INPUT}
        self.outputs = {n: v for n, v in views.items() if causality[n] is Causality.OUTPUT}
        self.remote.initialise(
            Setup(name="remote", parameters={}, tick=(1, self.rate), period=1, seed=0),
            self.inputs,
            self.outputs,
        )
        self.tick = 0
        self.deadline = 0.0

    def begin(self, own_deadline: int) -> None:
        self.deadline = float(own_deadline)

    def value(self, name: str) -> float:
        return float(self.outputs[name][0])

    def run_tick(self) -> None:
        self.now = round(self.deadline)
        session_tick = self.tick + self.first_tick
        self.grid.at_deadline(session_tick, self.now)
        self.remote.read(self.tick)
        own = self.source(session_tick)
        for name, value in zip(
            ("position", "source_tick", "source_age", "status"), own, strict=True
        ):
            self.inputs[f"vr_{self.name}.{name}"][0] = value
        self.remote.write(self.tick)
        if self.watch is not None:
            self.watch(self, session_tick)
        self.tick += 1
        self.deadline += self.tick_ns * (1.0 + self.grid.slew)


def share_session(
    a: SimulatedStation,
    b: SimulatedStation,
    number: int = 0,
    *,
    same: bool = False,
    later: bool = False,
) -> None:
    """Give both ends the keys that their handshake would; with ``later`` only the first sends."""
    ends = sorted((a, b), key=lambda station: station.name)
    keys = both_ends(names=(ends[0].name, ends[1].name), number=number)
    for station, mine in zip(ends, keys, strict=True):
        station.link.offer(mine, same=same)
        if station is a or not later:
            station.link.use(mine.session)


def run(network: Network, stations: list[SimulatedStation], until: int) -> None:
    """Run every living station's ticks in order of true time, up to ``until`` (ns, true)."""
    queue = [(s.clock.true(round(s.deadline)), i) for i, s in enumerate(stations) if s.alive]
    heapq.heapify(queue)
    by_name = {s.name: s for s in stations}
    while queue and queue[0][0] < until:
        true, index = heapq.heappop(queue)
        network.now = true
        for due, source, target, content in network.deliver(true):
            there = by_name.get(target)
            if there is not None and there.alive and source == there.peer:
                there.transport.queue.append((due, content))
        here = stations[index]
        if not here.alive:
            continue
        here.run_tick()
        heapq.heappush(queue, (here.clock.true(round(here.deadline)), index))
