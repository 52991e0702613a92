"""Both ends see what the way does: bursts, silence, a lasting delay, a radio that sleeps."""

from __future__ import annotations

import itertools

import pytest

from cosim.link.stream.fate import Fate
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer import PeerState, Reason
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import ACTIVE_STATUS, SimulatedStation, run, share_session

SECOND = 10**9
START = SECOND
WAY = BadNetwork(delay=0.002)


def two(network: Network, settings: LinkForm | None = None):
    a, b = (
        SimulatedStation(*names, network, SkewedClock(offset), settings=settings or LinkForm())
        for names, offset in (("ab", 10**15), ("ba", -(10**12)))
    )
    share_session(a, b)
    for station in (a, b):
        station.begin(station.clock.at(START))
        station.link.expect(4_000_000, 2_000_000)
    return a, b


def weights_of(station: SimulatedStation) -> list[float]:
    kept: list[float] = []
    station.watch = lambda s, _: kept.append(s.value("lan.weight"))
    return kept


def check_ramps(weights: list[float]) -> None:
    steps = [after - before for before, after in itertools.pairwise(weights)]
    assert max(steps) <= 1.001 / 1024
    assert min(steps) >= -1.001 / 52


def test_of_three_hundred_milliseconds_released_at_once_the_newest_counts() -> None:
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network)
    run(network, [a, b], START + 2 * SECOND)
    weights = weights_of(b)
    held = b.transport.queue
    b.transport.queue = kept = type(held)()
    shown: list[int] = []

    def keep_back(station, tick: int) -> None:
        weights.append(station.value("lan.weight"))
        shown.append(station.link.incoming[0].receiver.tick)

    b.watch = keep_back
    # Nothing is read for 300 ms, while the loop goes on; then all of it at once.
    receive = b.transport.receive
    b.transport.receive = lambda _: -1
    run(network, [a, b], START + 2 * SECOND + 300_000_000)
    assert len(kept) >= 37
    b.transport.receive = receive
    run(network, [a, b], START + 2 * SECOND + 320_000_000)
    assert b.link.intake.flood == 0
    receiver = b.link.incoming[0].receiver
    assert receiver.tick >= shown[-1] - 3 * 8
    assert receiver.counts[Fate.ACCEPTED] >= 250
    run(network, [a, b], START + 5 * SECOND)
    assert weights[-1] == 1.0
    check_ramps(weights)


@pytest.mark.parametrize("blind", ["a", "b"])
def test_whoever_is_not_heard_fades_as_whoever_hears_nothing(blind: str) -> None:
    """One direction is cut: the side that still receives must not go on in full."""
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network)
    run(network, [a, b], START + 2 * SECOND)
    deaf, heard = (a, b) if blind == "a" else (b, a)
    weights = {station.name: weights_of(station) for station in (a, b)}
    network.join("a", "b", WAY)
    network.impairers[heard.name, deaf.name] = network.impairers["a", "b"].__class__(
        BadNetwork(delay=0.002, loss=1.0), 1
    )
    run(network, [a, b], START + 3 * SECOND)
    # The hold, four samples and the round trip until it is missed, and the fade.
    assert 0.0 in weights[deaf.name][: 8 + 32 + 52 + 8]
    assert 0.0 in weights[heard.name][: 8 + 32 + 4 * 8 + 8 + 52 + 8]
    assert heard.value("lan.reason") == Reason.UNHEARD
    assert deaf.value("lan.reason") == Reason.SILENT
    network.join("a", "b", WAY)
    run(network, [a, b], START + 6 * SECOND)
    assert a.value("lan.weight") == b.value("lan.weight") == 1.0
    for kept in weights.values():
        check_ramps(kept)


@pytest.mark.parametrize("both_ways", [False, True])
def test_a_way_that_becomes_longer_for_good_is_accepted(both_ways: bool) -> None:
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network, LinkForm(max_delay=16))
    run(network, [a, b], START + 2 * SECOND)
    weights = weights_of(b)
    back = network.impairers["b", "a"]
    network.join("a", "b", BadNetwork(delay=0.082))
    if not both_ways:
        network.impairers["b", "a"] = back
    run(network, [a, b], START + 3 * SECOND)
    assert b.value("lan.weight") == 0.0
    assert b.value("lan.reason") == Reason.TOO_LATE
    run(network, [a, b], START + 6 * SECOND)
    assert a.value("lan.weight") == b.value("lan.weight") == 1.0
    check_ramps(weights)
    late = b.link.incoming[0].receiver.counts[Fate.LATE]
    run(network, [a, b], START + 7 * SECOND)
    assert b.link.incoming[0].receiver.counts[Fate.LATE] == late


def test_a_way_that_is_longer_than_the_bound_counts_for_nothing_and_says_so() -> None:
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network, LinkForm(max_delay=4))
    run(network, [a, b], START + 2 * SECOND)
    network.join("a", "b", BadNetwork(delay=0.082))
    run(network, [a, b], START + 8 * SECOND)
    for station in (a, b):
        assert station.value("lan.weight") == 0.0
        assert station.value("lan.state") == PeerState.LOST
        assert station.value("lan.reason") == Reason.TOO_LATE
    assert b.link.incoming[0].weight.losses == 1


def test_a_renewal_costs_no_packet_and_no_weight() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.005, jitter=0.001))
    a, b = two(network)
    run(network, [a, b], START + 2 * SECOND)
    weights = weights_of(a), weights_of(b)
    sent, accepted = a.link.outgoing.sent, b.link.incoming[0].receiver.counts[Fate.ACCEPTED]
    for number in range(1, 9):
        # The two ends hear of it at different times, as over a network.
        ends = (a, b) if number % 2 else (b, a)
        begin = START + 2 * SECOND + number * 200_000_000
        share_session(*ends, number=number, same=True, later=True)
        # Clocks are still the same ones.
        assert all(station.link.clock.ready for station in ends)
        run(network, [a, b], begin + 100_000_000)
        ends[1].link.use(ends[0].link.session.session)
        run(network, [a, b], begin + 200_000_000)
    run(network, [a, b], START + 4 * SECOND)
    assert set(weights[0]) == set(weights[1]) == {1.0}
    lost = (a.link.outgoing.sent - sent) - (
        b.link.incoming[0].receiver.counts[Fate.ACCEPTED] - accepted
    )
    assert lost <= 1, "the last one may be on its way"
    share_session(a, b, number=9)
    assert not any(station.link.clock.ready for station in (a, b))
    assert b.link.incoming[0].receiver.counts[Fate.FOREIGN] == 0


def test_an_own_stall_longer_than_the_hold_fades_and_comes_back_with_a_ramp() -> None:
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network)
    run(network, [a, b], START + 2 * SECOND)
    weights = weights_of(b)
    before = b.link.incoming[0].receiver.values.copy()
    b.deadline += 100_000_000
    b.clock.offset += 0
    run(network, [a, b], START + 2 * SECOND + 130_000_000)
    assert b.value("lan.reason") == Reason.STALLED
    # While it fades, what was held when it stood still is what counts.
    assert (b.link.incoming[0].receiver.values == before).all() or weights[-1] == 0.0
    run(network, [a, b], START + 5 * SECOND)
    check_ramps([1.0, *weights])
    assert 0.0 in weights


def test_whoever_joins_a_running_session_begins_with_a_ramp() -> None:
    network = Network()
    network.join("a", "b", WAY)
    a, _ = two(network)
    clock = SkewedClock(5)
    b = SimulatedStation("b", "a", network, clock, first_tick=2048)
    share_session(a, b, number=3)
    weights = weights_of(b)
    a.tick = 2048
    b.begin(clock.at(START))
    run(network, [a, b], START + 3 * SECOND)
    assert weights[-1] == 1.0
    check_ramps([0.0, *weights])


def test_a_radio_that_sleeps_costs_what_it_sleeps_and_no_more() -> None:
    """Wi-Fi power save: every two seconds nothing for 60 to 300 ms, then all of it at once."""
    network = Network()
    network.join("a", "b", WAY)
    a, b = two(network)
    run(network, [a, b], START + SECOND)
    weights = weights_of(b)
    receive = b.transport.receive
    for number in range(10):
        begin = START + SECOND + 2 * number * SECOND
        b.transport.receive = lambda _: -1
        run(network, [a, b], begin + 60_000_000 + number * 26_000_000)
        b.transport.receive = receive
        run(network, [a, b], begin + 2 * SECOND)
        # Back before the next sleep.
        assert weights[-1] == 1.0
    check_ramps(weights)
    assert sum(weights) / len(weights) > 0.6
    assert b.link.intake.flood == 0
    receiver = b.link.incoming[0].receiver
    assert receiver.counts[Fate.ACCEPTED] > 0.85 * a.link.outgoing.sent


def test_a_delay_that_is_chosen_is_what_nine_of_ten_need_and_then_stays() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.020, jitter=0.003))
    a, b = two(network, LinkForm(delay="auto", max_delay=8))
    for station in (a, b):
        station.link.expect(40_000_000, 24_000_000)
    run(network, [a, b], START + 4 * SECOND)
    receiver = b.link.incoming[0].receiver
    assert receiver.settings.delay == 4
    assert receiver.overdue < 0.1 * receiver.counts[Fate.ACCEPTED]
    b.link.expect(400_000_000, 240_000_000)
    assert receiver.settings.delay == 4
    capped = two(network, LinkForm(delay="auto", max_delay=3))[1]
    capped.link.expect(400_000_000, 240_000_000)
    assert capped.link.incoming[0].receiver.settings.delay == 3


@pytest.mark.parametrize(("rate", "period"), [(1024, 32), (1024, 16), (1024, 2), (1024, 1)])
def test_packets_at_any_rate_from_32_to_1024_a_second_are_carried(rate: int, period: int) -> None:
    network = Network()
    network.join("a", "b", WAY)
    clock = SkewedClock()
    a, b = (
        SimulatedStation(*names, network, clock, rate=rate, period=period) for names in ("ab", "ba")
    )
    share_session(a, b)
    a.source = b.source = lambda tick: (0.1, tick, 0, ACTIVE_STATUS)
    for station in (a, b):
        station.begin(START)
        station.link.expect(4_000_000, 2_000_000)
    weights = weights_of(b)
    run(network, [a, b], START + 2 * SECOND)
    # The first packet counts at once, and nothing is lost on a good way.
    first = weights.index(1.0)
    assert set(weights[first:]) == {1.0}
    assert b.link.outgoing.sent == 2 * rate // period
    receiver = b.link.incoming[0].receiver
    assert receiver.counts[Fate.ACCEPTED] >= 2 * rate // period - 4 // period - 3
    assert receiver.delay <= max(period, 4)
