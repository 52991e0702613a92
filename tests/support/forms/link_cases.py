"""For each key of ``link:``, two settings, and what two linked stations do with them."""

from __future__ import annotations

from typing import Any

from cosim.link.stream.form import LinkForm
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import SimulatedStation, run, share_session

START, SECOND = 10**9, 10**9
LOSSY = {"hold_samples": 1, "fade": 0.02, "resume": 0.05, "resume_samples": 2}

LINK_CASES: dict[str, tuple[dict[str, Any], dict[str, Any], dict[str, Any]]] = {
    "release": ({}, {"release": "network_tick"}, {"release": "arrival"}),
    "delay": ({}, {"delay": 1}, {"delay": 4}),
    "max_delay": ({**LOSSY, "hold": 0.001}, {"max_delay": 1}, {"max_delay": 8}),
    "clock": ({}, {"clock": "follow"}, {"clock": "free"}),
    "hold_samples": (LOSSY, {"hold_samples": 1}, {"hold_samples": 3}),
    "hold": ({**LOSSY, "hold_samples": 4}, {"hold": 0.001}, {"hold": 0.06}),
    "fade": (LOSSY, {"fade": 0.02}, {"fade": 0.2}),
    "resume": (LOSSY, {"resume": 0.05}, {"resume": 0.4}),
    "resume_samples": (LOSSY, {"resume_samples": 2}, {"resume_samples": 12}),
    "ramp_at_start": (LOSSY, {"ramp_at_start": False}, {"ramp_at_start": True}),
}


def what_two_stations_do(settings: LinkForm) -> list[Any]:
    """Weight, position and phase of every tick of a second over a late and lossy network."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.012, jitter=0.004, loss=0.2))
    clocks = SkewedClock(3 * 10**15, 0.0), SkewedClock(-(10**12), 100e-6)
    seen: list[Any] = []

    def watch(station: SimulatedStation, tick: int) -> None:
        del tick
        if station.name == "b":
            receiver = station.link.incoming[0].receiver
            seen.append((station.value("lan.weight"), station.value("phase"), receiver.released_at))

    stations = [
        SimulatedStation(*names, network, clock, settings=settings, watch=watch)
        for names, clock in zip((("a", "b"), ("b", "a")), clocks, strict=True)
    ]
    share_session(*stations)
    for station, clock in zip(stations, clocks, strict=True):
        station.begin(clock.at(START))
    run(network, stations, START + SECOND)
    return seen
