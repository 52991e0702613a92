"""A source with a deadband over the link: what the peer has is not sent again, and nothing differs
from a channel in which every packet has its values."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cosim.link.stream.fate import Fate
from cosim.link.stream.peer import PeerState, Reason
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network, SkewedClock
from tests.support.link.world import ACTIVE_STATUS, SimulatedStation, run, share_session

PERIOD, LONGEST, REPEATED = 8, 16, 128
SECOND = 1_000_000_000
Source = Callable[[int], tuple[float, int, int, int]]


def deadband(tick: int) -> tuple[float, int, int, int]:
    """A hand that moves for half a second and rests for half a second, as a deadband tells it."""
    sample = tick // PERIOD
    turn = sample % 128
    # While it moves every third sample is told, else one in sixteen.
    content = sample - (turn % 3 if turn < 64 else (turn - 64) % LONGEST)
    age = (sample - content) * PERIOD
    place = 0.002 * min(content % 128, 64)
    return place, tick, age, ACTIVE_STATUS | (REPEATED if age else 0)


def frozen(tick: int) -> tuple[float, int, int, int]:
    """The same, whose device says nothing new from the third second on."""
    place, source, age, status = deadband(tick)
    return place, source, age + max(0, tick - 3 * 1024), status


def watched(
    source: Source, seconds: float, *, loss: float = 0.0, delay: float = 2e-3, renew: bool = False
) -> tuple[list[tuple[int, int, float, float]], SimulatedStation, SimulatedStation]:
    """What b is shown of a: (tick, tick of its packet, place, age); and both stations."""
    network, clock = Network(), SkewedClock()
    network.join("a", "b", BadNetwork(delay=delay, loss=loss), seed=3)
    shown: list[tuple[int, int, float, float]] = []

    def watch(station: SimulatedStation, tick: int) -> None:
        receiver = station.link.incoming[0].receiver
        if receiver.tick >= 0:
            age = station.value("lan.age")
            shown.append((tick, receiver.tick, station.value("vr_a.position"), age))

    a = SimulatedStation("a", "b", network, clock, source=source)
    b = SimulatedStation("b", "a", network, clock, watch=watch)
    share_session(a, b)
    for station in (a, b):
        station.begin(SECOND)
    if renew:
        run(network, [a, b], SECOND + round(0.5 * seconds * SECOND))
        share_session(a, b, number=1, same=True)
    run(network, [a, b], SECOND + round(seconds * SECOND))
    return shown, a, b


@pytest.mark.parametrize("loss", [0.0, 0.3])
@pytest.mark.parametrize("delay", [2e-3, 20e-3])
def test_what_is_shown_is_what_the_source_said(loss: float, delay: float) -> None:
    shown, a, b = watched(deadband, 4.0, loss=loss, delay=delay)
    for tick, sampled, place, age in shown:
        said, _, source_age, _ = deadband(sampled)
        assert place == said
        assert age == tick - sampled + source_age
    stream = b.link.incoming[0]
    withheld = a.link.outgoing.contents[0].withheld
    assert 0 < stream.receiver.content.withheld <= withheld
    if loss == 0.0:
        assert stream.receiver.content.withheld >= withheld - 3
        assert stream.weight.losses == 0
        assert stream.weight.weight == 1.0


def test_a_resting_hand_costs_a_head_and_no_weight() -> None:
    _, a, b = watched(deadband, 4.0)
    assert a.link.outgoing.contents[0].withheld > 0.3 * a.link.outgoing.sent
    stream = b.link.incoming[0]
    assert stream.weight.state is PeerState.LIVE
    # The bare repetition of 16 samples would have been four times the hold.
    assert 3 * stream.weight.hold < (LONGEST - 1) * PERIOD


def test_a_device_that_says_nothing_new_fades_all_the_same() -> None:
    _, _, b = watched(frozen, 4.0)
    stream = b.link.incoming[0]
    assert stream.weight.state is PeerState.LOST
    assert stream.weight.causes[Reason.STALE] == 1


def test_a_new_session_begins_with_all_values() -> None:
    shown, a, b = watched(deadband, 4.0, loss=0.1, renew=True)
    assert all(place == deadband(sampled)[0] for _, sampled, place, _ in shown)
    assert a.link.outgoing.contents[0].withheld > 0
    assert b.link.incoming[0].receiver.counts[Fate.ABSURD] == 0


def test_who_repeats_without_saying_so_is_stale() -> None:
    def silent(tick: int) -> tuple[float, int, int, int]:
        place, source, age, status = deadband(tick)
        return place, source, age, status & ~REPEATED

    _, a, b = watched(silent, 4.0)
    assert a.link.outgoing.contents[0].withheld == 0
    assert b.link.incoming[0].weight.causes[Reason.STALE] > 0


def test_what_goes_on_beside_what_is_repeated_is_always_sent() -> None:
    """Waves are integrals that a deadband leaves alone."""

    def moving(tick: int) -> tuple[float, int, int, int]:
        _, source, age, status = deadband(tick)
        return 1e-4 * (tick % 4096), source, age, status

    shown, a, b = watched(moving, 2.0, loss=0.3)
    assert all(place == moving(sampled)[0] for _, sampled, place, _ in shown)
    assert a.link.outgoing.contents[0].withheld == 0
    assert b.link.incoming[0].weight.causes[Reason.STALE] == 0
