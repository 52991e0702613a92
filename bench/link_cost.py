"""What the link costs a tick, and how old remote data are when they are used.

    uv run python bench/link_cost.py

Two remote stations in one process over loopback sockets (the real transport, kernel stamps
included), 17 values as in two_users_box. Costs hold the system calls; the ideal age is the wire's
one-way time rounded up to the next network sample.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from cosim.base.component import Causality, Setup, VariableType
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.link.stream.fate import Fate
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.address import Address
from cosim.link.wire.sockets import open_socket
from cosim.link.wire.transport import UdpTransport
from cosim.station.admission import CompiledAdmission
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.support import PERIOD, TICK, both_ends
from tests.support.link.world import SimulatedStation, run, share_session

VALUES = 17
COUNT = 8000


def ends() -> tuple[RemoteStation, RemoteStation]:
    """Two stations that have met."""
    local = Address("127.0.0.1", 0)
    first = open_socket(local, None)
    second = open_socket(local, Address(*first.getsockname()))
    first.connect(second.getsockname())
    bundles = {
        s: PacketBundle(
            source=s,
            target=t,
            fields=tuple(
                Field(name=f"vr_{s}.value_{number}", unit="m", minimum=-1.0, maximum=1.0, speed=3.0)
                for number in range(VALUES)
            ),
            period=PERIOD,
            tick=TICK,
        )
        for s, t in ("ab", "ba")
    }
    remotes: list[RemoteStation] = []
    for (own, peer), socket, keys in zip(("ab", "ba"), (first, second), both_ends(), strict=True):
        link = PeerLink(
            sends=[bundles[own]],
            receives=[bundles[peer]],
            settings=[LinkForm()],
            transport=UdpTransport(socket),
            forward=lambda *_: None,
            judge=CompiledAdmission,
        )
        link.offer(keys, same=False)
        link.use(keys.session)
        grid = Grid(tick_ns=float(TICK * 10**9))
        remote = RemoteStation(link, grid=grid, now=time.monotonic_ns)
        cells = {
            v.name: np.zeros(1, np.float64 if v.type is VariableType.FLOAT64 else np.int64)
            for v in remote.variables
        }
        ways = {
            way: {v.name: cells[v.name] for v in remote.variables if v.causality is way}
            for way in (Causality.INPUT, Causality.OUTPUT)
        }
        setup = Setup(name="link", parameters={}, tick=(1, 1024), period=1, seed=0)
        remote.initialise(setup, ways[Causality.INPUT], ways[Causality.OUTPUT])
        remotes.append(remote)
    return remotes[0], remotes[1]


def cost() -> dict[str, float]:
    """Microseconds of CPU of each kind of tick, one after the other: all caches are warm."""
    a, b = ends()
    found: dict[str, list[int]] = {
        "tick that sends": [],
        "tick with a packet": [],
        "tick without": [],
        "tick with 32 forged": [],
    }
    clock = time.thread_time_ns
    forged = bytearray(b.link.outgoing.writers[0].datagram)
    for number in range(COUNT):
        tick = number * PERIOD
        start = clock()
        a.write(tick)
        sent = clock()
        b.read(tick + PERIOD)
        received = clock()
        b.read(tick + PERIOD + 1)
        found["tick that sends"].append(sent - start)
        found["tick with a packet"].append(received - sent)
        found["tick without"].append(clock() - received)
        b.write(tick)
        a.read(tick + PERIOD)
        if number % 8 == 0:
            forged[:] = a.link.outgoing.writers[0].datagram
            forged[-1] ^= 1
            for _ in range(32):
                a.link.transport.send(forged)
            start = clock()
            b.read(tick + PERIOD)
            found["tick with 32 forged"].append(clock() - start)
    return {part: statistics.median(times) * 1e-3 for part, times in found.items()}


def paced_cost() -> dict[str, float]:
    """Mean microseconds of reading and of sending a tick, in a loop that sleeps between its ticks.

    What else runs meanwhile leaves the caches cold. The medians of single kinds of ticks say where
    the mean comes from.
    """
    a, b = ends()
    with contextlib.suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))
    clock = time.perf_counter_ns
    reads: list[int] = []
    writes: list[int] = []
    accepted = [0]
    receiver = b.link.incoming[0].receiver
    due = time.monotonic()
    for tick in range(1, COUNT):
        due += float(TICK)
        time.sleep(max(0.0, due - time.monotonic()))
        start = clock()
        b.read(tick)
        read = clock()
        b.write(tick)
        reads.append(read - start)
        writes.append(clock() - read)
        accepted.append(receiver.tally[Fate.ACCEPTED])
        a.read(tick)
        a.write(tick)
    came = np.diff(accepted) > 0
    sends = np.arange(1, COUNT) % PERIOD == 0
    took, sent = np.array(reads) * 1e-3, np.array(writes) * 1e-3
    return {
        "reading, mean of all": float(took.mean()),
        "  tick with a packet": float(np.median(took[came])),
        "  tick without": float(np.median(took[~came])),
        "sending, mean of all": float(sent.mean()),
        "  tick that sends": float(np.median(sent[sends])),
    }


def ages(delay: float, jitter: float) -> tuple[float, float, float]:
    """Mean age at use (ms) over a minute, mean wire time (ms), the ideal age (ms)."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=delay, jitter=jitter))
    clocks = SkewedClock(0), SkewedClock(10**12, 20e-6)
    a, b = (
        SimulatedStation(*names, network, clock)
        for names, clock in zip(("ab", "ba"), clocks, strict=True)
    )
    share_session(a, b)
    seen: list[float] = []
    b.watch = lambda station, tick: seen.append(station.value("lan.age")) if tick > 2048 else None
    for station in (a, b):
        station.begin(station.clock.at(10**9))
        station.link.expect(int(2e9 * delay), int(1e9 * delay))
    run(network, [a, b], 21 * 10**9)
    wire = float(np.mean(network.impairers["a", "b"].injected.delays))
    sample = float(TICK) * PERIOD
    held = (PERIOD - 1) / 2 * float(TICK)
    ideal = np.ceil((wire + 1e-9) / sample) * sample + held
    return float(np.mean(seen)) * float(TICK) * 1e3, wire * 1e3, float(ideal) * 1e3


def main() -> None:
    for name, costs in (("one after the other", cost()), ("in a loop of 1024 Hz", paced_cost())):
        print(f"us a tick, {name}")
        for part, micro in costs.items():
            print(f"  {part:22s} {micro:6.1f}")
    print("\n   wire   jitter   age at use   ideal   ratio   (ms; ages are means over ticks)")
    for delay, jitter in ((0.0002, 0.0), (0.0012, 0.0003), (0.005, 0.0005), (0.009, 0.0005)):
        age, wire, ideal = ages(delay, jitter)
        print(f"{wire:7.3f} {jitter * 1e3:8.3f} {age:12.3f} {ideal:7.3f} {age / ideal:7.3f}")


if __name__ == "__main__":
    main()
