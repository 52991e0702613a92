"""What a board says of itself is judged at every reply: resets, a stage that is off, watchdogs."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.device.contract import Received, State
from hil.device.errors import BoardError, Cause, NodeLost
from hil.device.judge import LONGEST_STEP, SETTLING_REPLIES, Judge
from hil.drivers.samples import WrappingClock

SECONDS = st.floats(0.0, 4000.0)


@given(SECONDS, st.floats(0.0, 0.9 * LONGEST_STEP))
def test_a_clock_that_goes_on_is_nothing(begin, step):
    judge = Judge()
    for time in (begin, begin + step, begin + 2 * step):
        assert judge.verdict(Received(device_time=time), State.ACTIVE) is None


@given(SECONDS, st.floats(1e-6, 4000.0))
def test_a_clock_that_runs_back_is_a_board_that_has_started_anew(begin, back):
    judge = Judge()
    judge.verdict(Received(device_time=begin), State.INACTIVE)
    trip = judge.verdict(Received(device_time=begin - back), State.INACTIVE)
    assert trip is not None
    assert trip.cause is Cause.RESTARTED
    assert trip.cause.unhomes


def test_a_clock_that_leaps_is_one_too():
    judge = Judge()
    judge.verdict(Received(device_time=2500.0), State.ACTIVE)
    trip = judge.verdict(Received(device_time=4294.0), State.ACTIVE)
    assert trip is not None
    assert "leapt" in trip.sentence


@given(st.integers(0, 2**32 - 1), st.lists(st.integers(0, 2**31 - 1), max_size=20))
def test_a_clock_of_32_bits_is_followed_over_its_end(begin, steps):
    clock, total = WrappingClock(), begin
    assert clock.seconds(begin) == pytest.approx(begin * 1e-6)
    for step in steps:
        total += step
        assert clock.seconds(total & 0xFFFFFFFF) == pytest.approx(total * 1e-6)


def test_an_output_stage_that_went_off_is_a_fault_at_once():
    judge = Judge()
    judge.commanded_anew()
    assert judge.verdict(Received(enabled=True), State.ACTIVE) is None
    assert judge.verdict(Received(), State.ACTIVE) is None, "nothing that tells"
    trip = judge.verdict(Received(enabled=False), State.ACTIVE)
    assert trip is not None
    assert trip.cause is Cause.BOARD


def test_an_output_stage_that_never_goes_on_is_one_after_a_few_answers():
    judge = Judge()
    judge.commanded_anew()
    verdicts = [judge.verdict(Received(enabled=False), State.ACTIVE) for _ in range(20)]
    assert [v is None for v in verdicts[:SETTLING_REPLIES]] == [True] * SETTLING_REPLIES
    assert verdicts[SETTLING_REPLIES] is not None


def test_a_watchdog_that_fired_matters_while_active():
    fired = Received(watchdog_fired=True, enabled=False)
    assert Judge().verdict(fired, State.INACTIVE) is None
    trip = Judge().verdict(fired, State.ACTIVE)
    assert trip is not None
    assert "watchdog" in trip.sentence


@pytest.mark.parametrize("state", [State.INACTIVE, State.ACTIVE])
def test_an_error_is_what_it_says(state):
    for error in (BoardError("axis 1 burns"), NodeLost("node 3 is gone")):
        trip = Judge().verdict(Received(error=error), state)
        assert trip is not None
        assert (trip.cause, trip.sentence) == (error.cause, str(error))
