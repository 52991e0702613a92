"""A peer that is lost fades in the stated time and comes back slowly; its force never jumps."""

from __future__ import annotations

import itertools
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.link.stream.form import LossPolicy
from cosim.link.stream.peer import PeerState, PeerWeight, Reason

TICK = Fraction(1, 1024)
PERIOD = 8
FADE_TICKS = 52
RESUME_TICKS = 1024


def weight(**policy) -> PeerWeight:
    return PeerWeight(LossPolicy(**policy), period=PERIOD, tick=TICK)


def advance(peer: PeerWeight, ticks: range, *, arrives=True, source_age=0, active=True):
    return [
        peer.update(fresh=arrives and tick % PERIOD == 0, source_age=source_age, active=active)
        for tick in ticks
    ]


def test_nothing_counts_before_the_first_packet() -> None:
    peer = weight()
    assert set(advance(peer, range(40), arrives=False)) == {0.0}
    assert peer.update(fresh=True, source_age=0, active=True) == 1.0


def test_a_peer_that_comes_long_after_the_start_comes_with_a_ramp() -> None:
    """Its values are not those that both began with."""
    peer = weight()
    assert set(advance(peer, range(5000), arrives=False)) == {0.0}
    weights = advance(peer, range(5000, 5000 + 8 * 16 + RESUME_TICKS + 8))
    assert weights[8 * 15] == 0.0
    assert weights[-1] == 1.0
    assert max(b - a for a, b in itertools.pairwise(weights)) <= 1.001 / 1024


def test_the_hold_is_bounded_in_time_where_samples_are_rare() -> None:
    slow = PeerWeight(LossPolicy(), period=32, tick=TICK)
    assert slow.hold == 32
    assert PeerWeight(LossPolicy(hold=0.1), period=32, tick=TICK).hold == 103


def test_a_side_that_is_not_heard_fades_and_comes_back_when_it_is() -> None:
    peer = weight()
    advance(peer, range(801))
    heard = [
        peer.update(fresh=tick % PERIOD == 0, source_age=0, active=True, unheard=tick - 800)
        for tick in range(801, 1000)
    ]
    assert heard[30] == 1.0
    assert heard[32 + FADE_TICKS] == 0.0
    assert peer.reason is Reason.UNHEARD
    assert advance(peer, range(1000, 3000))[-1] == 1.0


@pytest.mark.parametrize("state", [0, 0.4, 1.0])
def test_giving_up_fades_from_the_present_weight(state: float) -> None:
    peer = weight(ramp_at_start=True)
    while peer.weight < state:
        advance(peer, range(8))
    before = peer.weight
    peer.give_up(Reason.STALLED)
    after = advance(peer, range(60))
    assert before - after[0] <= 1.001 / FADE_TICKS
    assert after[FADE_TICKS] == 0.0


def test_with_a_hand_at_the_device_the_start_is_a_ramp_too() -> None:
    peer = weight(ramp_at_start=True)
    weights = advance(peer, range(8 * 16 + RESUME_TICKS + 1))
    assert weights[8 * 15] == 0.0
    assert weights[-1] == 1.0
    assert max(b - a for a, b in itertools.pairwise(weights)) <= 1.001 / 1024


def test_a_silent_peer_is_held_four_samples_and_faded_in_fifty_milliseconds() -> None:
    peer = weight()
    advance(peer, range(801))
    weights = advance(peer, range(801, 1001), arrives=False)
    # The next packet is due after 8 ticks, and missing from then on.
    hold = PERIOD + 4 * PERIOD
    assert all(value == 1.0 for value in weights[: hold - 1])
    assert weights[hold - 1] < 1.0
    assert weights[hold + FADE_TICKS - 1] == 0.0
    assert peer.state is PeerState.LOST
    assert peer.losses == 1


def test_three_lost_packets_change_nothing() -> None:
    peer = weight()
    advance(peer, range(801))
    weights = advance(peer, range(801, 832), arrives=False) + advance(peer, range(832, 1000))
    assert set(weights) == {1.0}


def test_a_stale_source_in_fresh_packets_loses_its_weight_as_well() -> None:
    peer = weight()
    advance(peer, range(800))
    weights = [
        peer.update(fresh=tick % PERIOD == 0, source_age=max(0, tick - 800), active=True)
        for tick in range(800, 1000)
    ]
    gone = weights.index(0.0)
    assert gone <= PERIOD + 4 * PERIOD + FADE_TICKS


def test_an_inactive_source_fades_at_once() -> None:
    peer = weight()
    advance(peer, range(800))
    assert advance(peer, range(800, 800 + FADE_TICKS), active=False)[-1] == 0.0


def test_it_comes_back_after_sixteen_good_packets_over_one_second() -> None:
    peer = weight()
    advance(peer, range(800))
    advance(peer, range(800, 1000), arrives=False)
    weights = advance(peer, range(1000, 3000))
    begins = next(i for i, value in enumerate(weights) if value > 0.0)
    assert 15 * PERIOD <= begins <= 16 * PERIOD + 1
    assert weights.index(1.0) - begins in range(RESUME_TICKS - 2, RESUME_TICKS + 2)


@settings(deadline=None, max_examples=100)
@given(
    spells=st.lists(
        st.tuples(st.integers(1, 400), st.booleans(), st.integers(0, 100), st.booleans()),
        max_size=25,
    )
)
def test_the_weight_never_jumps_after_the_start_and_stays_within_bounds(spells) -> None:
    peer = weight(ramp_at_start=True)
    last, tick = 0.0, 0
    for length, arrives, age, active in spells:
        for value in advance(
            peer, range(tick, tick + length), arrives=arrives, source_age=age, active=active
        ):
            assert 0.0 <= value <= 1.0
            assert value - last <= 1.001 / RESUME_TICKS
            assert last - value <= 1.001 / FADE_TICKS
            last = value
        tick += length


@settings(deadline=None, max_examples=50)
@given(st.integers(1, 3000))
def test_whatever_was_before_a_dead_peer_has_no_weight_after_the_stated_time(before: int) -> None:
    peer = weight()
    advance(peer, range(before))
    assert advance(peer, range(before, before + 5 * PERIOD + FADE_TICKS), arrives=False)[-1] == 0.0
