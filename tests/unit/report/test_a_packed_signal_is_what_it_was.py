"""What a page shows of a signal is its values, to half of a 65,534th of their range."""

from __future__ import annotations

import json

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cosim.report.page.pack import LEVELS, pack, unpack

SIZES = st.integers(1, 300)
NUMBERS = st.floats(-1e12, 1e12) | st.just(float("nan"))


@given(arrays(np.float64, SIZES, elements=NUMBERS))
def test_a_number_is_off_by_half_a_step_at_most(values: np.ndarray) -> None:
    shown = unpack(json.loads(json.dumps(pack(values))))
    known = values[~np.isnan(values)]
    assert (np.isnan(shown) == np.isnan(values)).all()
    if known.size:
        step = np.ptp(known) / LEVELS
        rounding = 1e-15 * np.abs(known).max()
        assert np.abs(shown - values)[~np.isnan(values)].max() <= 0.5001 * step + rounding


@given(arrays(np.int64, SIZES, elements=st.integers(-30000, 30000)))
def test_whole_numbers_are_exact(values: np.ndarray) -> None:
    assert unpack(pack(values)).tolist() == values.tolist()


def test_extremes_stand_where_they_stood() -> None:
    values = np.zeros(10000)
    values[[17, 9000]] = 3.0, -2.0
    shown = unpack(pack(values))
    assert (shown.argmax(), shown.argmin()) == (17, 9000)
    assert (shown.max(), shown.min()) == (3.0, -2.0)


def test_what_is_infinite_is_an_end_of_what_is_not() -> None:
    assert unpack(pack(np.array([1.0, np.inf, -np.inf, 2.0]))).tolist() == [1.0, 2.0, 1.0, 2.0]


def test_a_signal_that_stands_still_takes_no_room() -> None:
    assert "data" not in pack(np.full(100000, 0.25))
    smooth = np.sin(np.linspace(0, 6, 61440))
    assert len(pack(smooth)["data"]) < 61440


def test_a_run_that_ran_away_is_shown_as_far_as_numbers_go() -> None:
    shown = unpack(pack(np.array([-1.7e308, 0.0, 1.7e308])))
    assert np.isfinite(shown).all()
    assert shown[0] < -7e307
    assert shown[2] > 7e307
