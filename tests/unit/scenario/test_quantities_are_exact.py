"""Numbers with units: exact, in any unit of the right dimension, refused in any other."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.quantities.quantity import (
    QuantityError,
    exact,
    format_exact,
    quantity,
    split_quantity,
)
from cosim.base.quantities.units import BASES, parse_unit

EXAMPLES = [
    ("2.44 ms", "s", Fraction(244, 100_000)),
    ("1/1024 s", "s", Fraction(1, 1024)),
    ("8192/3 Hz", "Hz", Fraction(8192, 3)),
    ("1 kHz", "Hz", Fraction(1000)),
    ("2 min", "s", Fraction(120)),
    ("20 %", "1", Fraction(1, 5)),
    ("100 g", "kg", Fraction(1, 10)),
    ("20 N/mm", "N/m", Fraction(20_000)),
    ("3 mN.m", "N.m", Fraction(3, 1000)),
    ("3 mN·m", "N.m", Fraction(3, 1000)),
    ("0.4 N.s/m", "N.s/m", Fraction(2, 5)),
    ("0.4 kg/s", "N.s/m", Fraction(2, 5)),
    ("670 kg.mm2", "kg.m2", Fraction(67, 100_000)),
    ("1 m/s^2", "m/s2", Fraction(1)),
    ("1 m·s⁻²", "m/s2", Fraction(1)),
    ("5", "N", Fraction(5)),
    ("1e-3", "s", Fraction(1, 1000)),
    ("-.5 m", "m", Fraction(-1, 2)),
    ("7 µs", "s", Fraction(7, 10**6)),
    (0.1, "s", Fraction(1, 10)),
    (3, "s", Fraction(3)),
]


@pytest.mark.parametrize(("written", "unit", "value"), EXAMPLES)
def test_a_quantity_means_its_value(written: str | float, unit: str, value: Fraction) -> None:
    assert quantity(written, unit) == value


def test_angles_are_as_exact_as_pi() -> None:
    assert float(quantity("180 deg", "rad")) == pytest.approx(math.pi, rel=1e-15)
    assert float(quantity("60 rpm", "rad/s")) == pytest.approx(2 * math.pi, rel=1e-15)


@pytest.mark.parametrize(
    ("written", "unit", "reason"),
    [
        ("2 Hz", "s", "does not convert to s"),
        ("2 m/s", "m", "does not convert to m"),
        ("2 rad/s", "Hz", "does not convert to Hz"),
        ("2 parsec", "m", "'parsec' is not a unit"),
        ("2 m/", "m", "'m/' is not a unit"),
        ("2 m,s", "m", "is not a unit"),
        ("two", "m", "'two' is not a number with a unit"),
        ("", "m", "is not a number"),
        ("1/0 s", "s", "divides by zero"),
        ("1e9999 s", "s", "is not a"),
        ("1e400", "m", "'1e400' is too large for a number of 64 bits"),
        ("-1e308 km", "m", "too large"),
        ("1e-400 m", "m", "too small"),
        (10**400, "m", "a whole number of so many digits is too large"),
        pytest.param(10**5000, "m", "so many digits is too large", id="beyond str"),
        (math.nan, "s", "is not a finite number"),
        (math.inf, "s", "is not a finite number"),
    ],
)
def test_what_cannot_be_meant_is_refused(written: str | float, unit: str, reason: str) -> None:
    with pytest.raises(QuantityError, match=reason):
        quantity(written, unit)


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_plain_number_keeps_every_digit(number: float) -> None:
    assert float(exact(number)) == number
    assert float(quantity(number, "m")) == number


@settings(deadline=None)
@given(st.fractions(max_denominator=10**6))
def test_what_is_written_out_is_read_back(value: Fraction) -> None:
    assert quantity(format_exact(value), "s") == value
    assert quantity(f"{format_exact(value)} s", "s") == value


UNITS = st.sampled_from(["m", "kg", "s", "A", "rad", "N", "V", "mm", "kHz", "g", "min", "J"])


@settings(deadline=None)
@given(
    st.lists(st.tuples(UNITS, st.integers(1, 3)), max_size=3),
    st.lists(st.tuples(UNITS, st.integers(1, 3)), max_size=3),
)
def test_a_product_of_units_has_their_factors_and_dimensions(
    above: list[tuple[str, int]], below: list[tuple[str, int]]
) -> None:
    text, factor, exponents = "1", Fraction(1), [0] * len(BASES)
    for symbol, power in above:
        text += f".{symbol}{power}"
    if below:
        text += f"/({'.'.join(f'{symbol}{power}' for symbol, power in below)})"
    for symbol, power in [*above, *((symbol, -power) for symbol, power in below)]:
        part = parse_unit(symbol)
        assert part.exponents is not None
        factor *= part.factor**power
        exponents = [a + power * b for a, b in zip(exponents, part.exponents, strict=True)]
    product = parse_unit(text)
    assert product.factor == factor
    assert product.exponents == tuple(exponents)


@settings(deadline=None)
@given(st.text(max_size=12))
def test_any_text_is_a_quantity_or_refused_in_a_sentence(text: str) -> None:
    try:
        number, unit = split_quantity(text)
    except QuantityError as error:
        assert repr(text)[1:-1] in repr(str(error))  # noqa: PT017
    else:
        assert isinstance(number, Fraction)
        assert unit is None or unit.strip() == unit
