"""Lists, ranges and logarithmic ranges of a sweep, with their units."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.sweep.planning.axis import SweepAxis, number_of, parse_values, range_of
from cosim.sweep.planning.design import Sampling, points_of


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1, 2, 5", (1, 2, 5)),
        ("0..3", (0, 1, 2, 3)),
        ("0..1:0.25", (0.0, 0.25, 0.5, 0.75, 1.0)),
        ("0..1/3", (0.0, 0.5, 1.0)),
        ("0..1/2", (0, 1)),
        ("0..10/3", (0, 5, 10)),
        ("-2..2:2", (-2, 0, 2)),
        ("1..100/3 log", (1.0, 10.0, 100.0)),
        ("0..20 ms/3", ("0 ms", "10 ms", "20 ms")),
        ("1 ms..3 ms/3", ("1 ms", "2 ms", "3 ms")),
        ("step, sine", ("step", "sine")),
        ("true, false", (True, False)),
        ("[1, 2], [3, 4]", ("[1, 2]", "[3, 4]")),
        ("7", (7,)),
    ],
)
def test_values(text: str, values: tuple[Any, ...]) -> None:
    found, _ = parse_values("x", text)
    assert len(found) == len(values)
    for one, other in zip(found, values, strict=True):
        assert type(one) is type(other)
        assert one == other or (isinstance(one, float) and math.isclose(one, other))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("5..1", "lies above"),
        ("0..0.5", "how many points"),
        ("0..10/3:1", "no whole number of steps"),
        ("0..1:0.3", "no whole number of steps"),
        ("0..10/5 log", "begins above 0"),
        ("1..10 log", "needs its number of points"),
        ("1 ms..2 s/5", "one unit"),
        ("1,,2", "empty value"),
        ("0..1/0", "there may be 1 to"),
        ("a..b", "not a number"),
    ],
)
def test_what_no_range_is(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse_values("x", text)


@given(st.integers(-1000, 1000), st.integers(1, 1000), st.integers(2, 50), st.booleans())
def test_a_range_ends_where_it_says(low: int, span: int, points: int, log: bool) -> None:
    first = abs(low) + 1 if log else low
    found = range_of("x", first, first + span, points=points, is_log=log).values()
    numbers = [number_of(value) for value in found]
    assert numbers[0] == first
    assert numbers[-1] == first + span
    assert numbers == sorted(numbers)  # type: ignore[type-var]
    assert len(numbers) == points


@pytest.mark.parametrize("sample", [Sampling.LATIN_HYPERCUBE, Sampling.SOBOL])
def test_a_sample_is_spread_over_the_ranges(sample: Sampling) -> None:
    axes = [
        SweepAxis("x", ("a",), *parse_values("x", "0..1/2")),
        SweepAxis("y", ("b",), *parse_values("y", "10..1000/2 log")),
        SweepAxis("n", ("c",), *parse_values("n", "0..7")),
        SweepAxis("word", ("d",), *parse_values("word", "p, q")),
    ]
    points = points_of(axes, sample, 64, seed=3)
    assert len(points) == 128
    assert points == points_of(axes, sample, 64, seed=3)
    assert points != points_of(axes, sample, 64, seed=4)
    for half in range(2):
        x = sorted(float(point[0]) for point in points[64 * half : 64 * half + 64])
        assert [math.floor(64 * value) for value in x] == list(range(64))  # one in each row
    assert sum(float(point[1]) < 100 for point in points[:64]) == 32
    assert sorted({point[2] for point in points}) == list(range(8))  # type: ignore[type-var]
    assert {point[3] for point in points[:64]} == {"p"}


def test_a_sobol_sequence_has_a_power_of_two() -> None:
    with pytest.raises(InputError, match="take 64 or 128"):
        points_of([SweepAxis("x", ("a",), *parse_values("x", "0..1/2"))], Sampling.SOBOL, 100)
