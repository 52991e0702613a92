"""Models take ages as 32-bit integers: after 24 days, or on a word of the peer, none is larger."""

from __future__ import annotations

import pytest

from cosim.link.stream.admission import Admission
from cosim.link.stream.form import LinkForm
from cosim.link.stream.incoming import LARGEST_AGE, Incoming
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import ACTIVE_STATUS, SimulatedStation, bundle, run, share_session


@pytest.mark.parametrize("tick", [2**31 - 1, 2**31, 2**31 + 5, 2**40])
def test_a_silent_peer_grows_no_older_than_the_largest_age(tick: int) -> None:
    stream = bundle("a", "b", 1024, 8)
    item = Incoming(stream, LinkForm(), Admission(stream))
    item.release(tick, unheard=0, in_session=True)
    assert item.age == LARGEST_AGE == 2**31 - 1


@pytest.mark.parametrize("said", [2**31, 2**53])
def test_a_source_is_no_older_than_the_largest_age_whatever_it_says(said: int) -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.001))
    a, b = (
        SimulatedStation(
            *names, network, SkewedClock(0), source=lambda tick: (0.0, tick, said, ACTIVE_STATUS)
        )
        for names in ("ab", "ba")
    )
    share_session(a, b)
    ages: list[float] = []
    b.watch = lambda station, tick: ages.append(station.value("lan.age"))
    for station in (a, b):
        station.begin(10**9)
    run(network, [a, b], 2 * 10**9)
    assert max(ages) == LARGEST_AGE
    # A source so old is stale: after the hold it does not count.
    assert b.value("lan.weight") == 0.0
