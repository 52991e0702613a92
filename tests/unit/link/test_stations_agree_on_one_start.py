"""Stations agree on one start over a bad network, and one that comes back joins the grid."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import pytest

from cosim.link.session.contract import Contract
from cosim.link.session.live import KEEP_SIZE
from cosim.link.session.negotiator import side_of
from cosim.link.session.start import StartAgreement
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.support import KEY

TICK = Fraction(1, 1024)
PERIOD = 8
STEP = 1_000_000


@dataclass
class Station:
    name: str
    clock: SkewedClock
    agreement: StartAgreement


def station(name: str, others: list[str], clock: SkewedClock) -> Station:
    contract = Contract({"rate": 128})
    sides = {peer: side_of(name, peer, KEY, contract) for peer in others if peer != name}
    agreement = StartAgreement(own=name, sides=sides, tick=TICK, period=PERIOD)
    return Station(name, clock, agreement)


def run(network: Network, stations: list[Station], until: int, done=lambda: False) -> None:
    """Let stations poll every millisecond; datagrams carry the receiver's own arrival time."""
    by_name = {station.name: station for station in stations}
    while network.now < until and not done():
        network.now += STEP
        for due, source, target, content in network.deliver(network.now):
            if target in by_name:
                there = by_name[target]
                answer = there.agreement.receive(
                    source, content, there.clock.at(due), there.clock.at(network.now)
                )
                if answer is not None:
                    network.send(target, source, answer)
        for here in stations:
            for peer, content in here.agreement.poll(here.clock.at(network.now)):
                network.send(here.name, peer, content)


def start_instants(stations: list[Station]) -> list[float]:
    """True time (ns) of session tick 0 at every station."""
    return [
        s.clock.true(s.agreement.start.epoch) for s in stations if s.agreement.start is not None
    ]


CLOCKS = [SkewedClock(10**15, 30e-6), SkewedClock(-7 * 10**12, -40e-6), SkewedClock(5, 0.0)]


@pytest.mark.parametrize("count", [2, 3])
def test_thirty_starts_of_thirty_over_jitter_and_loss(count: int) -> None:
    names = ["a", "b", "c"][:count]
    spread = []
    for seed in range(30):
        network = Network()
        for i, first in enumerate(names):
            for second in names[i + 1 :]:
                network.join(
                    first, second, BadNetwork(delay=0.006, jitter=0.005 / 3, loss=0.2), seed * 10
                )
        stations = [station(name, names, clock) for name, clock in zip(names, CLOCKS, strict=False)]
        run(network, stations, 30 * 10**9, lambda s=stations: all(x.agreement.start for x in s))
        instants = start_instants(stations)
        assert len(instants) == count
        assert all(
            s.agreement.start is not None and s.agreement.start.first_tick == 0 for s in stations
        )
        assert min(instants) > network.now
        spread.append(max(instants) - min(instants))
    # Five milliseconds of jitter, the lowest round trips of some sixteen: about a millisecond.
    assert sorted(spread)[len(spread) // 2] < 2e6
    assert max(spread) < 6e6


def test_the_start_is_as_synchronous_as_the_network_is_symmetric() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.001, jitter=0.0003))
    stations = [station(name, ["a", "b"], clock) for name, clock in zip("ab", CLOCKS, strict=False)]
    run(network, stations, 10**10, lambda: all(s.agreement.start for s in stations))
    first, second = start_instants(stations)
    assert abs(first - second) < 300_000


def test_one_that_comes_back_joins_the_grid_at_a_network_tick() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.001, jitter=0.0003, loss=0.2))
    a, b = (station(name, ["a", "b"], clock) for name, clock in zip("ab", CLOCKS, strict=False))
    run(network, [a, b], 10**10, lambda: all(s.agreement.start for s in (a, b)))
    assert a.agreement.start is not None
    assert b.agreement.start is not None
    epoch_of_b = b.agreement.start.epoch
    network.now += 10**9
    b.agreement.run_on(epoch_of_b)
    # The leader's process dies and comes back; the follower hears nothing and asks again.
    again = station("a", ["a", "b"], CLOCKS[0])
    run(network, [again, b], network.now + 10**10, lambda: again.agreement.start is not None)
    start = again.agreement.start
    assert start is not None
    assert start.first_tick > 0
    assert start.first_tick % PERIOD == 0
    true_epoch = CLOCKS[1].true(epoch_of_b)
    assert abs(CLOCKS[0].true(start.epoch) - true_epoch) < 500_000
    begins = CLOCKS[0].true(start.epoch) + start.first_tick * 10**9 / 1024
    assert 0.9e9 < begins - network.now < 1.1e9


def test_a_replayed_or_forged_clock_message_changes_nothing() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.001))
    stations = [station(name, ["a", "b"], SkewedClock()) for name in "ab"]
    a, b = stations
    kept: list[bytes] = []
    receive = a.agreement.receive

    def listen(peer, datagram, received, now):
        kept.append(datagram)
        return receive(peer, datagram, received, now)

    a.agreement.receive = listen
    run(network, stations, 10**9, lambda: a.agreement.start is not None)
    samples, dropped = a.agreement.clock("b").samples, a.agreement.side("b").drops.total
    old = [message for message in kept if len(message) == KEEP_SIZE]
    for message in old:
        receive("b", message, network.now, network.now)
        changed = bytearray(message)
        changed[16] ^= 0x80
        receive("b", bytes(changed), network.now, network.now)
    assert a.agreement.clock("b").samples == samples
    assert a.agreement.side("b").drops.total == dropped + 2 * len(old)
    assert b.agreement.start is None or b.agreement.start.first_tick == 0


def test_two_that_both_run_keep_in_touch_and_do_not_answer_each_other_for_ever() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.001))
    stations = [station(name, ["a", "b"], SkewedClock()) for name in "ab"]
    run(network, stations, 10**10, lambda: all(s.agreement.start for s in stations))
    for s in stations:
        s.agreement.run_on(0)
    run(network, stations, network.now + 10**9)
    sent = network.sent
    sessions = [s.agreement.sessions() for s in stations]
    run(network, stations, network.now + 10 * 10**9)
    # Four questions and four answers a second.
    assert 70 <= network.sent - sent <= 90
    assert [s.agreement.sessions() for s in stations] == sessions


def test_a_grid_that_cannot_be_is_not_joined() -> None:
    """Its holder has the key and says that it began a century ago, or begins in one."""
    for epoch in (-(10**18), 10**18, 10**11):
        network = Network()
        network.join("a", "b", BadNetwork(delay=0.001))
        a, b = (station(name, ["a", "b"], SkewedClock()) for name in "ab")
        a.agreement.run_on(epoch)
        run(network, [a, b], 3 * 10**9)
        assert b.agreement.start is None
        assert b.agreement.absurd > 0
