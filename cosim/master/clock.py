"""Time as an integer tick: rates are fractions, and seconds are only ever shown, never compared."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from cosim.errors import InputError

HYPERPERIOD_LIMIT = 1 << 22
"""Longest pattern of due components that is compiled (ticks)."""

EXACT = 1 << 53
"""Whole numbers up to here are exact in a double."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The base rate (Hz) and what follows from it."""

    base_rate: Fraction

    @property
    def tick(self) -> Fraction:
        """One base tick (s)."""
        return 1 / self.base_rate

    def seconds(self, tick: int) -> float:
        """The time of a tick (s), rounded once."""
        return float(tick * self.tick)

    def step(self, period: int, substeps: int = 1) -> float:
        """The length of one of ``substeps`` equal steps over ``period`` ticks (s), rounded once."""
        return float(period * self.tick / substeps)

    def nearest_rates(self, rate: Fraction) -> tuple[Fraction, ...]:
        """The one or two rates next to ``rate`` (Hz) whose period is a whole number of ticks."""
        ticks = self.base_rate / rate
        periods = {max(1, math.floor(ticks)), max(1, math.ceil(ticks))}
        return tuple(sorted(self.base_rate / period for period in periods))

    def period(self, rate: Fraction, what: str) -> int:
        """The period of ``rate`` in ticks.

        Raises:
            InputError: it is not a whole number of ticks; says which rates are.
        """
        ticks = self.base_rate / rate
        if ticks.denominator != 1:
            fitting = " or ".join(f"{format_rate(near)} Hz" for near in self.nearest_rates(rate))
            raise InputError(
                f"{what} has a rate of {format_rate(rate)} Hz, which is not a whole number of ticks"
                f" of the base rate {format_rate(self.base_rate)} Hz; use {fitting}"
            )
        return ticks.numerator

    def hyperperiod(self, periods: Iterable[int]) -> int:
        """After how many ticks the pattern of due components repeats.

        Raises:
            InputError: later than ``HYPERPERIOD_LIMIT``.
        """
        pattern = math.lcm(*periods)
        if pattern > HYPERPERIOD_LIMIT:
            raise InputError(
                f"these rates only fall together every {pattern} ticks of "
                f"{format_rate(self.base_rate)} Hz, more than {HYPERPERIOD_LIMIT}; choose rates "
                "that divide each other"
            )
        return pattern

    def check_exact(self, ticks: int, substeps: int, name: str) -> None:
        """Refuse a run so long that a tick's time could not be rounded just once."""
        if ticks * substeps * self.base_rate.denominator >= EXACT:
            raise InputError(
                f"{ticks} ticks with {substeps} sub-steps of {name} are too many to keep time "
                "exactly; shorten the run"
            )


def common_rate(rates: Iterable[Fraction]) -> Fraction:
    """The least common multiple of rates (Hz): the slowest clock that ticks at all of them."""
    common = Fraction(0)
    for rate in rates:
        if rate <= 0:
            raise InputError(f"a rate must be above zero, not {format_rate(rate)} Hz")
        common = _least_common_multiple(common, rate) if common else rate
    return common


def format_rate(rate: Fraction) -> str:
    """A rate as people write it: a whole number, a short decimal, or a fraction."""
    if rate.denominator == 1:
        return str(rate.numerator)
    decimal = f"{float(rate):.6f}".rstrip("0")
    return decimal if Fraction(decimal) == rate else str(rate)


def _least_common_multiple(a: Fraction, b: Fraction) -> Fraction:
    return Fraction(
        math.lcm(a.numerator * b.denominator, b.numerator * a.denominator),
        a.denominator * b.denominator,
    )
