"""Offset and skew from four timestamps; a grid that keeps its phase by slewing."""

from __future__ import annotations

import random
import statistics

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.link.stream.phase import PhaseFollower
from cosim.link.wire.clock import ClockEstimate


def errors(
    seed: int, *, forward: float, backward: float, jitter: float, skew: float
) -> list[float]:
    """Offset errors (s) once a second, after the first twenty, over a minute at 128 Hz."""
    draw = random.Random(seed)
    estimate = ClockEstimate()
    found = []
    for number in range(128 * 60):
        sent = number * 7_812_500
        there = sent + round((forward + draw.uniform(-jitter, jitter)) * 1e9)
        back = there + 3_000_000
        received = back + round((backward + draw.uniform(-jitter, jitter)) * 1e9)

        def peer(true: int) -> int:
            return 10**14 + true + round(skew * true)

        estimate.add(sent, peer(there), peer(back), received)
        if number % 128 == 127:
            estimate.update(received)
            if number > 128 * 20:
                found.append((estimate.offset(received) - (peer(received) - received)) * 1e-9)
    assert estimate.skew == pytest.approx(skew, abs=10e-6)
    return found


@pytest.mark.parametrize("skew", [0.0, 30e-6, -100e-6])
def test_the_regression_is_within_fifty_microseconds_on_a_link_of_one_millisecond(skew) -> None:
    found = [
        error
        for seed in range(4)
        for error in errors(seed, forward=1e-3, backward=1e-3, jitter=0.5e-3, skew=skew)
    ]
    assert statistics.fmean(error**2 for error in found) ** 0.5 < 50e-6


def test_half_of_an_asymmetry_is_the_error_that_nobody_can_see() -> None:
    found = errors(1, forward=1e-3, backward=2e-3, jitter=0.0, skew=0.0)
    assert statistics.fmean(found) == pytest.approx(-0.5e-3, abs=5e-6)


@settings(deadline=None, max_examples=50)
@given(times=st.lists(st.tuples(*[st.integers(-(2**62), 2**62)] * 4), max_size=30))
def test_nonsense_times_do_no_harm(times) -> None:
    estimate = ClockEstimate()
    for exchange in times:
        trip = (exchange[3] - exchange[0]) - (exchange[2] - exchange[1])
        before = estimate.samples
        estimate.add(*exchange)
        sensible = exchange[0] <= exchange[3] and max(map(abs, exchange[1:3])) <= 2**60
        assert (estimate.samples > before) == (0 <= trip < 10**10 and sensible)
        estimate.update(exchange[3])
        assert -1e-3 <= estimate.skew <= 1e-3
    assert estimate.refused == len(times) - estimate.samples


@pytest.mark.parametrize("skew", [-100e-6, 0.0, 100e-6])
@pytest.mark.parametrize("phase", [-500e-6, 0.0, 500e-6])
def test_the_grid_is_slewed_and_never_stepped(skew: float, phase: float) -> None:
    """``skew``: what the leader's clock gains; the phase grows by what is left of it."""
    follower = PhaseFollower()
    for _ in range(60):
        correction = follower.update(phase, skew)
        assert abs(correction) <= 200e-6
        phase += skew + correction
    assert abs(phase) < 1e-6


def test_a_drift_beyond_the_limit_is_counted() -> None:
    follower = PhaseFollower()
    follower.update(0.0, 300e-6)
    assert follower.correction == -200e-6
    assert follower.saturated == 1
