"""The base tick divides every period exactly; what does not fit is refused with what does."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import ceil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.scenario.build.timebase import (
    FINEST,
    Timebase,
    check_base_rate,
    choose_base_rate,
    common_rate,
)
from cosim.scenario.form.fields import Lag

Load = Callable[..., Scenario]
RATES = st.fractions(min_value=1, max_value=5000, max_denominator=12)


@settings(deadline=None)
@given(st.lists(RATES, min_size=1, max_size=4))
def test_the_common_rate_is_the_least_that_all_divide(rates: list[Fraction]) -> None:
    common = common_rate(rates)
    periods = [common / rate for rate in rates]
    assert all(period.denominator == 1 for period in periods)
    for prime in (2, 3, 5, 7, 11, 13):  # a smaller one would leave a period that is not whole
        assert any((period / prime).denominator != 1 for period in periods)


@settings(deadline=None)
@given(st.lists(RATES, min_size=1, max_size=4, unique=True))
def test_what_is_kept_fits_and_what_is_refused_does_not(rates: list[Fraction]) -> None:
    named = {f"r{i}": rate for i, rate in enumerate(rates)}
    timebase, refused = choose_base_rate(named)
    assert timebase.base_rate <= FINEST * max(rates)
    for name, rate in named.items():
        if name in refused:
            assert common_rate([timebase.base_rate, rate]) > timebase.base_rate
        else:
            assert timebase.period(rate) == timebase.base_rate / rate


@settings(deadline=None)
@given(RATES, RATES)
def test_the_rate_offered_instead_fits_and_none_is_nearer(base: Fraction, rate: Fraction) -> None:
    sentences = check_base_rate(base, {"it": rate})
    if not sentences:
        assert (base / rate).denominator == 1
        return
    offered = Fraction(sentences["it"].split("nearest rate that fits is ")[1].split(" Hz")[0])
    if rate <= base:
        divisors = [base / n for n in range(1, ceil(base / rate) + 2)]
        assert float(offered) == pytest.approx(float(min(divisors, key=lambda d: abs(d - rate))))


@settings(deadline=None)
@given(RATES, st.fractions(min_value=0, max_value=100, max_denominator=10**6))
def test_a_time_is_rounded_up_to_ticks(base: Fraction, seconds: Fraction) -> None:
    ticks = Timebase(base).delay(Lag(seconds, "s"), period=4).ticks
    assert ticks >= seconds * base > ticks - 1


def test_the_thesis_rates(small: str, scenario_of: Load) -> None:
    scenario = scenario_of(small)
    assert scenario.base_rate == 1024
    assert scenario.ticks == 2048
    assert scenario.channels["lan"].period == 8
    assert scenario_of(small, sets=("duration=1.0001",)).ticks == 1025


def test_rational_ratios_run(small: str, scenario_of: Load) -> None:
    scenario = scenario_of(small, sets=("rates.network=768",))
    assert scenario.base_rate == 3072
    assert scenario.components["left"].period == 3
    assert scenario.channels["lan"].period == 4
    finer = scenario_of(small, sets=("rates.network=100", "base_rate=25600"))
    assert (finer.components["left"].period, finer.channels["lan"].period) == (25, 256)
    with pytest.raises(InputError, match=r"nearest rate that fits is 102\.4 Hz"):
        scenario_of(small, sets=("rates.network=100",))
