"""Two stations' loops over a network, with clocks that drift, a peer that freezes or dies."""

from __future__ import annotations

import itertools

import pytest

from cosim.link.stream.fate import Fate
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer import PeerState
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import ACTIVE_STATUS, SimulatedStation, run, share_session

SECOND = 10**9
START = SECOND


def two(network: Network, skew: float = 0.0, start_error: int = 0, **settings):
    """Stations a and b that have met: a common start, up to ``start_error`` (ns)."""
    clocks = SkewedClock(3 * 10**15, 0.0), SkewedClock(-(10**12), skew)
    a = SimulatedStation("a", "b", network, clocks[0], **settings)
    b = SimulatedStation("b", "a", network, clocks[1], **settings)
    share_session(a, b)
    a.begin(clocks[0].at(START))
    b.begin(clocks[1].at(START + start_error))
    return a, b


FREE = LinkForm(clock="free")
FULL_RATE = pytest.param(1024, 8, marks=pytest.mark.slow)


@pytest.mark.parametrize(("rate", "period"), [(32, 1), FULL_RATE])
@pytest.mark.parametrize("skew", [-100e-6, 100e-6])
def test_ten_minutes_with_drifting_crystals_keep_n_constant(
    skew: float, rate: int, period: int
) -> None:
    """60 ms of drift if nothing were done: eight network samples at full rate, two at 32 Hz.

    Full rate takes minutes: ``uv run pytest -m slow tests``.
    """
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002, jitter=0.0003, loss=0.01))
    delays: dict[str, set[int]] = {"a": set(), "b": set()}
    phases: list[float] = []

    def watch(station: SimulatedStation, tick: int) -> None:
        if station.link.incoming[0].fresh:
            receiver = station.link.incoming[0].receiver
            delays[station.name].add(receiver.released_at - receiver.tick)
        if station.name == "b" and tick % rate == 0:
            phases.append(station.value("phase"))

    # At 32 Hz two packets lost in a row are longer than the hold.
    settings = LinkForm(hold=1.0)
    a, b = two(network, skew, start_error=200_000, rate=rate, period=period, settings=settings)
    a.watch = b.watch = watch
    run(network, [a, b], START + 600 * SECOND)
    assert delays == {"a": {period}, "b": {period}}
    assert max(abs(phase) for phase in phases[40:]) < 300e-6
    assert b.remote.follower is not None
    assert abs(b.grid.slew) == pytest.approx(100e-6, abs=20e-6)
    assert a.grid.slew == 0.0
    assert a.link.incoming[0].weight.losses == b.link.incoming[0].weight.losses == 0


def test_with_free_clocks_the_slip_is_reported_and_nothing_is_lost() -> None:
    """100 ppm over four minutes: 24 ms, three ticks of 1/128 s."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002, jitter=0.0003))
    a, b = two(network, 100e-6, rate=128, period=4, settings=FREE)
    run(network, [a, b], START + 240 * SECOND)
    assert b.grid.slew == a.grid.slew == 0.0
    assert a.value("phase") == pytest.approx(0.024, abs=2e-4)
    assert b.value("phase") == pytest.approx(-0.024, abs=2e-4)
    assert a.link.incoming[0].receiver.slip == -3
    assert b.link.incoming[0].receiver.slip == 3
    assert b.value("clock_skew") == pytest.approx(-100e-6, abs=5e-6)
    assert a.link.incoming[0].weight.losses == b.link.incoming[0].weight.losses == 0


def test_counters_equal_what_the_network_did() -> None:
    network = Network()
    network.join(
        "a",
        "b",
        BadNetwork(
            delay=0.003,
            jitter=0.001,
            loss=0.05,
            duplicate=0.03,
            reorder=0.03,
            reorder_delay=0.02,
            corrupt=0.02,
        ),
    )
    a, b = two(network)
    run(network, [a, b], START + 20 * SECOND)
    a.alive = False
    run(network, [a, b], START + 20 * SECOND + SECOND // 10)
    done = network.impairers["a", "b"].injected
    counts = b.link.incoming[0].receiver.counts
    lost_in_header = b.link.foreign + len(b.forwarded)
    arrived = int(counts.sum()) - int(counts[Fate.SUPERSEDED]) + lost_in_header
    assert arrived == a.link.outgoing.sent - done.lost + done.copies
    bad = counts[Fate.FORGED] + counts[Fate.FOREIGN] + counts[Fate.TRUNCATED] + lost_in_header
    assert bad == done.corrupted
    assert done.duplicated == counts[Fate.DUPLICATE]
    # A packet kept back 20 ms is overtaken by two or three others.
    reordered = counts[Fate.REORDERED]
    assert 0.9 * done.reordered <= reordered + bad <= done.reordered + bad + 2
    assert counts[[Fate.LATE, Fate.OUT_OF_RANGE, Fate.JUMP, Fate.REPLAYED]].sum() == 0


def test_an_authentic_peer_with_a_frozen_finger_loses_its_weight_in_time() -> None:
    """Fresh packets, honest about the age of what is in them."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = two(network)
    frozen = 2048

    def source(tick: int):
        return 0.0, tick, max(0, tick - frozen), ACTIVE_STATUS

    a.source = source
    gone: list[int] = []
    ages: list[float] = []

    def watch(station: SimulatedStation, tick: int) -> None:
        if tick > frozen:
            ages.append(station.value("lan.age"))
            if station.value("lan.weight") == 0.0:
                gone.append(tick)

    b.watch = watch
    run(network, [a, b], START + 3 * SECOND)
    # One sample of the way, one until the next packet, four held, 50 ms of fading.
    assert gone[0] - frozen <= 8 + 8 + 4 * 8 + 8 + 52
    assert ages[-1] >= 900


def test_a_peer_whose_model_stands_still_is_found_without_its_help() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = two(network)
    a.source = lambda tick: (0.0, min(tick, 2048), 0, ACTIVE_STATUS)
    run(network, [a, b], START + 3 * SECOND)
    assert b.value("lan.weight") == 0.0
    assert b.link.incoming[0].receiver.counts[Fate.ACCEPTED] > 380


def test_a_source_that_is_not_active_is_not_valid() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = two(network)
    a.source = lambda tick: (0.0, tick, 0, 1 if tick > 1024 else ACTIVE_STATUS)
    run(network, [a, b], START + 3 * SECOND)
    assert b.value("lan.valid") == 0.0
    assert b.value("lan.weight") == 0.0


def test_killing_and_restarting_one_side_never_jumps_and_heals_by_itself() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002, jitter=0.0003))
    a, b = two(network)
    weights: list[float] = []
    b.watch = lambda station, tick: weights.append(station.value("lan.weight"))
    run(network, [a, b], START + 2 * SECOND)
    assert weights[-1] == 1.0
    a.alive = False
    run(network, [a, b], START + 4 * SECOND)
    assert weights[-1] == 0.0
    # It comes back with another clock, its own tick 0 at a network tick of the running grid.
    clock = SkewedClock(7 * 10**14, 50e-6)
    again = SimulatedStation("a", "b", network, clock, first_tick=4096)
    again.begin(clock.at(START + 4 * SECOND))
    share_session(again, b, number=1)
    values: list[float] = []
    again.watch = lambda station, tick: values.append(station.value("lan.weight"))
    run(network, [again, b], START + 8 * SECOND)
    assert weights[-1] == values[-1] == 1.0
    steps = [y - x for x, y in itertools.pairwise(weights[2000:])]
    assert max(steps) <= 1.001 / 1024
    assert min(steps) >= -1.001 / 52


def test_an_orderly_stop_fades_the_peer_at_once() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002, loss=0.3))
    a, b = two(network)
    run(network, [a, b], START + SECOND)
    a.remote.close()
    a.alive = False
    run(network, [a, b], START + SECOND + 80_000_000)
    assert b.value("lan.state") == PeerState.LOST


def test_a_wide_area_link_is_slow_and_not_late() -> None:
    """60 ms there and back: eight samples are this link's nature."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.030, jitter=0.001))
    a, b = two(network)
    for station in (a, b):
        station.link.expect(60_000_000, 30_000_000)
    run(network, [a, b], START + 5 * SECOND)
    assert a.value("lan.weight") == b.value("lan.weight") == 1.0
    assert a.link.incoming[0].receiver.counts[Fate.LATE] == 0
    held = b.link.incoming[0].receiver
    assert held.released_at - held.tick in {32, 40}


def test_packets_kept_back_on_the_way_are_dropped_although_authentic() -> None:
    """An attacker who can only delay: in order, all of them, 200 ms late."""
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = two(network)
    run(network, [a, b], START + 2 * SECOND)
    network.join("a", "b", BadNetwork(delay=0.200))
    run(network, [a, b], START + 4 * SECOND)
    assert b.value("lan.weight") == 0.0
    assert b.link.incoming[0].receiver.counts[Fate.LATE] > 200


def test_a_flood_is_cut_at_half_a_seconds_packets_a_tick() -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002))
    a, b = two(network)
    run(network, [a, b], START + SECOND)
    before = b.link.incoming[0].receiver.counts.sum()
    b.transport.queue.extend((network.now, bytes(100)) for _ in range(1000))
    b.link.drain(1024)
    counted = b.link.incoming[0].receiver.counts.sum() - before + b.link.foreign
    assert counted == 64
    assert b.link.intake.flood == 1000 - 64
