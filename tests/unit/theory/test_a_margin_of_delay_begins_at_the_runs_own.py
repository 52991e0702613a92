"""The margin of delay is counted from the delay that the run has, to the tick, at any base rate."""

from __future__ import annotations

from fractions import Fraction

import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.run_margins import delay_margin
from cosim.analysis.answers.vary import intervals_of_run
from cosim.scenario.load import read

NAME = "single_axis_distributed"
BASE, PERIOD, TICKS = 3000, 24, 5
"""With a sample more 29 ticks, of which the nearest double in seconds is a little more."""


def sets(ticks: int) -> list[str]:
    return [
        f"base_rate={BASE}",
        "rates.control=3000 Hz",
        "rates.network=125 Hz",
        "channels.lan.round_trip_delay=~",
        f"channels.lan.delay={{forward: {ticks} ticks, backward: 0}}",
    ]


def stiffest(ticks: int) -> float:
    with ask(read(NAME, (), sets(ticks))) as asked:
        return intervals_of_run(asked, "k_12", 500.0, 3000.0)[0][1]


@pytest.mark.slow
def test_a_loop_that_stands_one_sample_more_but_no_tick_beyond_has_a_margin_of_one() -> None:
    assert Fraction(repr((TICKS + PERIOD) / BASE)) > Fraction(TICKS + PERIOD, BASE)
    most, later = stiffest(TICKS + PERIOD), stiffest(TICKS + PERIOD + 1)
    assert later < most
    k_12 = (most + later) / 2
    with ask(read(NAME, (), sets(TICKS)), settings=[("k_12", k_12)]) as asked:
        assert delay_margin(asked) == 1
