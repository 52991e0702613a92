"""The root finder finds what SciPy's Brent finds, in about as many calls."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from cosim.theory.numerics import find_root

number = st.floats(-10, 10, allow_subnormal=False)
FUNCTIONS = {
    "cubic": lambda x, a, b: (x - a) ** 3 + b * (x - a) + 0.1 * b,
    "steep": lambda x, a, b: math.expm1(min(50.0, 3 * (x - a))) + 1e-3 * b,
    "flat": lambda x, a, b: math.atan(x - a) ** 5 + 1e-9 * b,
    "kinked": lambda x, a, b: max(x - a, 0.1 * (x - a)) + 0.01 * b,
}


@pytest.mark.parametrize("kind", FUNCTIONS)
@given(number, number, st.floats(-40, -30), st.floats(30, 40))
def test_the_same_zero(kind: str, a: float, b: float, low: float, high: float) -> None:
    calls = 0

    def function(x: float) -> float:
        nonlocal calls
        calls += 1
        return FUNCTIONS[kind](x, a, b)

    found = find_root(function, low, high)
    ours = calls
    _, details = brentq(function, low, high, xtol=1e-13, rtol=4e-15, maxiter=200, full_output=True)
    assert low <= found <= high
    nearby = 4e-13 + 1e-14 * abs(found)
    sides = [FUNCTIONS[kind](x, a, b) for x in (found - nearby, found + nearby)]
    assert min(sides) <= 0.0 <= max(sides), "the sign changes within the tolerance"
    assert ours <= 2 * details.function_calls + 20


def test_no_change_of_sign_is_refused() -> None:
    with pytest.raises(ValueError, match="no change of sign"):
        find_root(lambda x: x * x + 1, -1, 1)
    assert find_root(lambda x: x, 0.0, 1.0) == 0.0
    assert find_root(lambda x: x - 1, 0.0, 1.0) == 1.0
