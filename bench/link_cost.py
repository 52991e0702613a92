"""What the link costs a tick, and how old remote data are when they are used.

    uv run python bench/link_cost.py

Two ends in one process over loopback sockets (the real transport, kernel stamps included), 17
values as in two_users_box. Figures are the median of several rounds; the ideal age is the wire's
one-way time rounded up to the next network sample.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from cosim.link.bundle import Bundle, Field
from cosim.link.impairment import Impairment
from cosim.link.peer_link import PeerLink
from cosim.link.settings import LinkSettings
from cosim.link.transport import Address, UdpTransport, open_socket
from tests.link.simulated import Network, SkewedClock
from tests.link.support import PERIOD, TICK, both_ends
from tests.link.world import SimulatedStation, run, share_session

VALUES = 17
ROUNDS = 7
COUNT = 4000


def ends() -> tuple[PeerLink, PeerLink]:
    local = Address("127.0.0.1", 0)
    first = open_socket(local, None)
    second = open_socket(local, Address(*first.getsockname()))
    first.connect(second.getsockname())
    bundles = {
        s: Bundle(
            source=s,
            target=t,
            fields=(Field(name=f"vr_{s}.shared", size=VALUES),),
            period=PERIOD,
            tick=TICK,
        )
        for s, t in ("ab", "ba")
    }
    links = [
        PeerLink(
            sends=[bundles[own]],
            receives=[bundles[peer]],
            settings=[LinkSettings()],
            transport=UdpTransport(socket),
            forward=lambda *_: None,
        )
        for (own, peer), socket in zip(("ab", "ba"), (first, second), strict=True)
    ]
    for link, keys in zip(links, both_ends(), strict=True):
        link.renew(keys)
    return links[0], links[1]


def cost() -> dict[str, float]:
    """Microseconds of CPU of each part, system calls included."""
    a, b = ends()
    found: dict[str, list[float]] = {"send": [], "receive": [], "empty tick": [], "flooded": []}
    tick = 0
    for _ in range(ROUNDS):
        spent = dict.fromkeys(found, 0.0)
        for _ in range(COUNT):
            tick += PERIOD
            start = time.process_time()
            a.send(tick, time.monotonic_ns(), 0)
            sent = time.process_time()
            b.drain(tick)
            b.release(tick)
            received = time.process_time()
            b.drain(tick + 1)
            b.release(tick + 1)
            empty = time.process_time()
            spent["send"] += sent - start
            spent["receive"] += received - sent
            spent["empty tick"] += empty - received
        # Forged packets at 20 times the rate are 2.5 a tick; this is the most a tick ever reads.
        forged = bytearray(a.writers[0].datagram)
        forged[-1] ^= 1
        for _ in range(COUNT // 40):
            for _ in range(40):
                a.transport.send(forged)
            start = time.process_time()
            b.drain(tick)
            spent["flooded"] += 40 * (time.process_time() - start)
        for part, seconds in spent.items():
            found[part].append(seconds / COUNT * 1e6)
    return {part: statistics.median(values) for part, values in found.items()}


def ages(delay: float, jitter: float) -> tuple[float, float, float]:
    """Mean age at use (ms) over a minute, mean wire time (ms), the ideal age (ms)."""
    network = Network()
    network.join("a", "b", Impairment(delay=delay, jitter=jitter))
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
        station.link.allow(int(2e9 * delay))
    run(network, [a, b], 21 * 10**9)
    wire = float(np.mean(network.impairers["a", "b"].injected.delays))
    sample = float(TICK) * PERIOD
    held = (PERIOD - 1) / 2 * float(TICK)
    ideal = np.ceil((wire + 1e-9) / sample) * sample + held
    return float(np.mean(seen)) * float(TICK) * 1e3, wire * 1e3, float(ideal) * 1e3


def main() -> None:
    for part, micro in cost().items():
        print(f"{part:12s} {micro:6.1f} us")
    print("\n   wire   jitter   age at use   ideal   ratio   (ms; ages are means over ticks)")
    for delay, jitter in ((0.0002, 0.0), (0.0012, 0.0003), (0.005, 0.0005), (0.009, 0.0005)):
        age, wire, ideal = ages(delay, jitter)
        print(f"{wire:7.3f} {jitter * 1e3:8.3f} {age:12.3f} {ideal:7.3f} {age / ideal:7.3f}")


if __name__ == "__main__":
    main()
