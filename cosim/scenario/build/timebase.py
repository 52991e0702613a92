"""The base tick, and everything that is counted in it.

The base rate is the least common multiple of all rates, so that every period is a whole number of
ticks and nothing is ever compared in floating seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import ceil, gcd, lcm

from cosim.base.quantities.quantity import format_exact
from cosim.scenario.form.fields import Lag
from cosim.scenario.model import Delay

FINEST = 8
"""Base ticks in one period of the fastest rate, unless ``base_rate`` says otherwise. Rates that fit
only with more are seldom meant, and each tick costs a turn of the loop."""


@dataclass(frozen=True, slots=True)
class Timebase:
    """Base ticks a second (Hz)."""

    base_rate: Fraction

    def period(self, rate: Fraction) -> int:
        """Ticks in one period of a rate that fits."""
        ticks = self.base_rate / rate
        assert ticks.denominator == 1
        return ticks.numerator

    def ticks(self, seconds: Fraction) -> int:
        """A time in ticks; between two ticks it is rounded up."""
        return ceil(seconds * self.base_rate)

    def delay(self, lag: Lag, period: int) -> Delay:
        """A written delay in ticks; a sample is ``period`` ticks."""
        if lag.unit == "samples":
            return Delay(ticks=int(lag.amount) * period, samples=int(lag.amount))
        ticks = int(lag.amount) if lag.unit == "ticks" else self.ticks(lag.amount)
        return Delay(ticks=ticks, samples=None if ticks else 0)


def common_rate(rates: list[Fraction]) -> Fraction:
    """The least common multiple of rates: the smallest that each divides."""
    multiple = rates[0]
    for rate in rates[1:]:
        multiple = Fraction(
            lcm(multiple.numerator, rate.numerator), gcd(multiple.denominator, rate.denominator)
        )
    return multiple


def choose_base_rate(rates: dict[str, Fraction]) -> tuple[Timebase, dict[str, str]]:
    """The time base of rates, and a sentence for every rate that does not fit.

    ``rates`` are by the name to use in the sentence, at least one. A rate that does not fit is left
    out of the time base.
    """
    fastest = max(rates, key=lambda name: rates[name])
    base, refused = rates[fastest], dict[str, str]()
    for name in sorted(rates, key=lambda name: rates[name], reverse=True):
        finer = common_rate([base, rates[name]])
        if finer <= FINEST * rates[fastest]:
            base = finer
            continue
        near = _nearest(rates[fastest], rates[name])
        refused[name] = (
            f"{name} does not fit: with it, one period of {fastest} would be "
            f"{finer / rates[fastest]} base ticks (at most {FINEST}). The nearest rate that fits "
            f"is {hertz(near)}; or write 'base_rate: {hertz(finer)}' to have the finer tick."
        )
    return Timebase(base), refused


def check_base_rate(base: Fraction, rates: dict[str, Fraction]) -> dict[str, str]:
    """A sentence for every rate that does not divide a given base rate."""
    return {
        name: f"{name} does not fit base_rate, {hertz(base)}, which must be a whole multiple of "
        f"it. The nearest rate that fits is {hertz(_nearest(base, rate))}."
        for name, rate in rates.items()
        if (base / rate).denominator != 1
    }


def hertz(rate: Fraction) -> str:
    """A rate as it is written in a scenario."""
    return f"{format_exact(rate)} Hz"


def _nearest(fast: Fraction, rate: Fraction) -> Fraction:
    """The divisor of ``fast`` that lies nearest to ``rate``."""
    whole = int(fast / rate)
    return min((fast / n for n in (whole, whole + 1) if n), key=lambda near: abs(near - rate))
