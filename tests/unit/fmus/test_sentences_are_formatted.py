"""What models say reads as a person would write it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.fmus.native_support import library


def formatted(text: str, integer: int, number: float) -> list[str]:
    return library().probe_format(text.encode(), integer, number).decode().split("|")


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0.0, "0"),
        (-0.0, "-0"),
        (1.0, "1"),
        (-2.5, "-2.5"),
        (0.1, "0.1"),
        (1 / 1024, "0.0009765625"),
        (0.00001, "0.00001"),
        (0.000001, "1e-6"),
        (123456789.0, "123456789"),
        (1234567890.0, "1.23456789e9"),
        (99999999.9999, "100000000"),
        (1e300, "1e300"),
        (5e-324, "4.94065646e-324"),
        (math.nan, "NaN"),
        (math.inf, "infinity"),
        (-math.inf, "-infinity"),
    ],
)
def test_numbers(number: float, text: str) -> None:
    assert formatted("", 0, number)[2] == text


@settings(deadline=None)
@given(
    number=st.floats(allow_nan=False, allow_infinity=False),
    integer=st.integers(-(2**31), 2**31 - 1),
)
def test_numbers_read_back_to_nine_digits(number: float, integer: int) -> None:
    _, whole, text, percent = formatted("x", integer, number)
    assert (whole, percent) == (str(integer), "%")
    assert float(text) == pytest.approx(number, rel=6e-9, abs=1e-315)


def test_a_long_sentence_is_cut_off() -> None:
    said = library().probe_format(b"x" * 1000, 1, 1.0)
    assert said == b"x" * 511
