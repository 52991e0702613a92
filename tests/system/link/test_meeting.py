"""Stations agree on one start over a bad network, and one that comes back joins the grid."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import pytest

from cosim.link.session.contract import Contract
from cosim.link.session.handshake import Handshake
from cosim.link.session.meeting import SYNC_SIZE, Meeting, State
from cosim.testing.impairment import Impairment
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.support import KEY

TICK = Fraction(1, 1024)
PERIOD = 8
STEP = 1_000_000


@dataclass
class Station:
    name: str
    clock: SkewedClock
    meeting: Meeting


def station(name: str, others: list[str], clock: SkewedClock) -> Station:
    contract = Contract({"rate": 128})
    handshakes = {
        peer: Handshake(own=name, peer=peer, key=KEY, contract=contract)
        for peer in others
        if peer != name
    }
    return Station(name, clock, Meeting(own=name, handshakes=handshakes, tick=TICK, period=PERIOD))


def run(network: Network, stations: list[Station], until: int, done=lambda: False) -> None:
    """Let doors poll every millisecond; datagrams carry the receiver's own arrival time."""
    by_name = {station.name: station for station in stations}
    while network.now < until and not done():
        network.now += STEP
        for due, source, target, content in network.deliver(network.now):
            if target in by_name:
                there = by_name[target]
                answer = there.meeting.receive(
                    source, content, there.clock.at(due), there.clock.at(network.now)
                )
                if answer is not None:
                    network.send(target, source, answer)
        for here in stations:
            for peer, content in here.meeting.poll(here.clock.at(network.now)):
                network.send(here.name, peer, content)


def start_instants(stations: list[Station]) -> list[float]:
    """True time (ns) of session tick 0 at every station."""
    return [s.clock.true(s.meeting.start.epoch) for s in stations if s.meeting.start is not None]


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
                    first, second, Impairment(delay=0.006, jitter=0.005 / 3, loss=0.2), seed * 10
                )
        stations = [station(name, names, clock) for name, clock in zip(names, CLOCKS, strict=False)]
        run(network, stations, 30 * 10**9, lambda s=stations: all(x.meeting.start for x in s))
        instants = start_instants(stations)
        assert len(instants) == count
        assert all(
            s.meeting.start is not None and s.meeting.start.first_tick == 0 for s in stations
        )
        assert min(instants) > network.now
        spread.append(max(instants) - min(instants))
    # Five milliseconds of jitter, the lowest round trips of some sixteen: about a millisecond.
    assert sorted(spread)[len(spread) // 2] < 2e6
    assert max(spread) < 6e6


def test_the_start_is_as_synchronous_as_the_network_is_symmetric() -> None:
    network = Network()
    network.join("a", "b", Impairment(delay=0.001, jitter=0.0003))
    stations = [station(name, ["a", "b"], clock) for name, clock in zip("ab", CLOCKS, strict=False)]
    run(network, stations, 10**10, lambda: all(s.meeting.start for s in stations))
    first, second = start_instants(stations)
    assert abs(first - second) < 300_000


def test_one_that_comes_back_joins_the_grid_at_a_network_tick() -> None:
    network = Network()
    network.join("a", "b", Impairment(delay=0.001, jitter=0.0003, loss=0.2))
    a, b = (station(name, ["a", "b"], clock) for name, clock in zip("ab", CLOCKS, strict=False))
    run(network, [a, b], 10**10, lambda: all(s.meeting.start for s in (a, b)))
    assert a.meeting.start is not None
    assert b.meeting.start is not None
    epoch_of_b = b.meeting.start.epoch
    network.now += 10**9
    b.meeting.run_on(epoch_of_b)
    # The leader's process dies and comes back; the follower's loop has told its door to ask again.
    again = station("a", ["a", "b"], CLOCKS[0])
    b.meeting._guests["a"].handshake.ask_again()
    run(network, [again, b], network.now + 10**10, lambda: again.meeting.start is not None)
    start = again.meeting.start
    assert start is not None
    assert start.first_tick > 0
    assert start.first_tick % PERIOD == 0
    true_epoch = CLOCKS[1].true(epoch_of_b)
    assert abs(CLOCKS[0].true(start.epoch) - true_epoch) < 500_000
    begins = CLOCKS[0].true(start.epoch) + start.first_tick * 10**9 / 1024
    assert 0.9e9 < begins - network.now < 1.1e9


def test_a_replayed_or_forged_clock_message_changes_nothing() -> None:
    network = Network()
    network.join("a", "b", Impairment(delay=0.001))
    stations = [station(name, ["a", "b"], SkewedClock()) for name in "ab"]
    a, b = stations
    kept: list[bytes] = []
    receive = a.meeting.receive

    def listen(peer, datagram, received, now):
        kept.append(datagram)
        return receive(peer, datagram, received, now)

    a.meeting.receive = listen
    run(network, stations, 10**9, lambda: a.meeting.start is not None)
    samples, dropped = a.meeting.clock("b").samples, a.meeting.dropped
    old = [message for message in kept if len(message) == SYNC_SIZE]
    for message in old:
        receive("b", message, network.now, network.now)
        changed = bytearray(message)
        changed[16] ^= 0x80
        receive("b", bytes(changed), network.now, network.now)
    assert a.meeting.clock("b").samples == samples
    assert a.meeting.dropped == dropped + 2 * len(old)
    assert b.meeting.start is None or b.meeting.start.first_tick == 0


def test_two_that_both_run_do_not_answer_each_other_for_ever() -> None:
    network = Network()
    network.join("a", "b", Impairment(delay=0.001))
    stations = [station(name, ["a", "b"], SkewedClock()) for name in "ab"]
    run(network, stations, 10**10, lambda: all(s.meeting.start for s in stations))
    for s in stations:
        s.meeting.run_on(0)
    run(network, stations, network.now + 10**9)
    assert network.next_due() is None
    assert State.RUNNING
