"""A packet that missed its sample is the network's where its way was long, else its sender's."""

from __future__ import annotations

from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import SimulatedStation, run, share_session

SECOND = 10**9


def met(network: Network) -> tuple[SimulatedStation, SimulatedStation]:
    clocks = SkewedClock(3 * 10**15), SkewedClock(-(10**12))
    a = SimulatedStation("a", "b", network, clocks[0])
    b = SimulatedStation("b", "a", network, clocks[1])
    share_session(a, b)
    for station, clock in ((a, clocks[0]), (b, clocks[1])):
        station.begin(clock.at(SECOND))
    run(network, [a, b], 4 * SECOND)
    assert b.link.incoming[0].receiver.overdue == 0
    return a, b


def test_a_slow_network_is_to_blame() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = met(network)
    network.join("a", "b", BadNetwork(delay=0.009))
    run(network, [a, b], 4 * SECOND + SECOND // 4)
    item = b.link.incoming[0]
    assert item.receiver.overdue > 20
    assert item.overdue_by_network == item.receiver.overdue


def test_a_sender_that_was_held_up_is_to_blame() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.003))
    a, b = met(network)
    a.deadline += 6_000_000
    run(network, [a, b], 4 * SECOND + SECOND // 4)
    item = b.link.incoming[0]
    assert item.receiver.overdue > 20
    assert item.overdue_by_network == 0
