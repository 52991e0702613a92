"""Whatever the receive path raises is counted, and the packets around it are used."""

from __future__ import annotations

import struct

import pytest

from cosim.link.stream.fate import Fate
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import SimulatedStation, run, share_session

SECOND = 10**9


@pytest.mark.parametrize("error", [ValueError, OverflowError, struct.error, KeyError, MemoryError])
@pytest.mark.parametrize("part", ["accept", "learn"])
def test_a_fault_is_counted_and_the_others_are_used(error, part, monkeypatch) -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = (SimulatedStation(*names, network, SkewedClock(0, 0.0)) for names in ("ab", "ba"))
    share_session(a, b)
    for station in (a, b):
        station.begin(SECOND)
    where = b.link if part == "learn" else b.link.incoming[0].receiver
    name = "_learn" if part == "learn" else "accept"
    honest, seen = getattr(where, name), []

    def faulty(*given):
        seen.append(given)
        if len(seen) % 5 == 3:
            raise error("an error of ours")
        return honest(*given)

    monkeypatch.setattr(where, name, faulty)
    weights: list[float] = []
    b.watch = lambda station, _: weights.append(station.value("lan.weight"))
    run(network, [a, b], 3 * SECOND)
    assert b.link.faulty == sum(number % 5 == 2 for number in range(len(seen))) > 20
    assert b.link.incoming[0].receiver.tally[Fate.ACCEPTED] > 180
    # One packet in five is as good as lost: the peer is held, and never given up.
    assert set(weights[64:]) == {1.0}
    assert b.link.incoming[0].weight.losses == 0
