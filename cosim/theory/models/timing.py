"""Rates and delays: the control period, the network period, and what the network adds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Literal

from cosim.base.errors import InputError

Sampling = Literal["last_tick", "between_ticks"]
"""What is sent between two control ticks, where the ratio is not whole: what was measured and
computed at the last of them, as the master and every real device do, or what is so right then."""

LONGEST_DELAY = 500
"""Network samples one way. A loop's order grows with its delay, its matrices with the square."""
LONGEST_COMPUTATION_DELAY = 250
"""Ticks of T_c, for the same reason."""
LONGEST_HYPERPERIOD = 100_000
"""Base ticks until T_c and T_t coincide again, each of which is a product of matrices."""


@dataclass(frozen=True, slots=True)
class PathDelay:
    """The delay of the two directions of a channel, in whole network samples and ticks beyond them.

    ``forward`` is from the first-named end (centralized: from the client to the server;
    distributed: from the lower user number to the higher), ``backward`` the other way. A tick is
    the timing's base tick; with one the loop has no frame map, and is lifted as a whole.
    """

    forward: int = 0
    backward: int = 0
    forward_ticks: int = 0
    backward_ticks: int = 0

    def __post_init__(self) -> None:
        """Refuse negative delays, and those that no analysis here can carry.

        Raises:
            InputError: where a delay is negative or longer than ``LONGEST_DELAY``.
        """
        for name, (samples, ticks) in zip(("forward", "backward"), self.ways, strict=True):
            if ticks < 0:
                raise InputError(f"The {name} delay is {ticks} ticks: it cannot be negative.")
            if samples < 0:
                raise InputError(
                    f"The {name} delay is {samples} network samples: it cannot be negative."
                )
            if samples > LONGEST_DELAY:
                raise InputError(
                    f"The {name} delay is {samples} network samples; the theory goes up to "
                    f"{LONGEST_DELAY} one way."
                )

    @staticmethod
    def round_trip(samples: int) -> PathDelay:
        """A round trip of n samples: ⌈n/2⌉ forward and ⌊n/2⌋ backward."""
        if samples < 0:
            raise InputError(
                f"The round-trip delay is {samples} network samples: it cannot be negative."
            )
        return PathDelay(forward=samples - samples // 2, backward=samples // 2)

    @staticmethod
    def each_way(samples: int) -> PathDelay:
        """The same n samples in both directions."""
        return PathDelay(forward=samples, backward=samples)

    @property
    def total(self) -> int:
        """The round trip, in network samples (the thesis's n)."""
        return self.forward + self.backward

    @property
    def ways(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Samples and ticks forward, and backward."""
        return (self.forward, self.forward_ticks), (self.backward, self.backward_ticks)

    @property
    def is_whole(self) -> bool:
        """Whether both directions take whole samples."""
        return not self.forward_ticks and not self.backward_ticks


@dataclass(frozen=True, slots=True)
class Timing:
    """Sampling of a cooperative loop.

    Attributes:
        control_period: T_c in s.
        ratio: T_t / T_c, any positive rational.
        delay: delay of the two directions of the network, in network samples.
        computation_delay: ticks of T_c between a coupler's inputs and its force (z⁻¹ when 1).
        sampling: what is sent between two control ticks; of no account where the ratio is whole.
    """

    control_period: Fraction = Fraction(1, 1024)
    ratio: Fraction = Fraction(8)
    delay: PathDelay = field(default_factory=PathDelay)
    computation_delay: int = 0
    sampling: Sampling = "last_tick"

    def __post_init__(self) -> None:
        """Refuse what is not a sampling.

        Raises:
            InputError: where a period or the ratio is not positive, the computation delay is
                negative, or one of them is too large for the analysis.
        """
        if self.control_period <= 0:
            raise InputError(f"The control period is {self.control_period} s: it must be positive.")
        if self.ratio <= 0:
            raise InputError(
                f"The ratio of the network period to the control period is {self.ratio}: "
                "it must be positive, such as 8 for 128 Hz packets under 1024 Hz control."
            )
        if self.hyperperiod_ticks > LONGEST_HYPERPERIOD:
            raise InputError(
                f"The ratio {self.ratio} makes the periods coincide only every "
                f"{self.hyperperiod_ticks} ticks; the theory goes up to {LONGEST_HYPERPERIOD}."
            )
        if self.computation_delay > LONGEST_COMPUTATION_DELAY:
            raise InputError(
                f"The computation delay is {self.computation_delay} ticks; the theory goes up to "
                f"{LONGEST_COMPUTATION_DELAY}."
            )
        if self.computation_delay < 0:
            raise InputError(
                f"The computation delay is {self.computation_delay} ticks: it cannot be negative."
            )

    @property
    def control_ticks(self) -> int:
        """T_c in base ticks (the largest period that divides T_c and T_t)."""
        return self.ratio.denominator

    @property
    def network_ticks(self) -> int:
        """T_t in base ticks."""
        return self.ratio.numerator

    @property
    def hyperperiod_ticks(self) -> int:
        """The least common multiple of T_c and T_t, in base ticks."""
        return self.control_ticks * self.network_ticks

    @property
    def base_period(self) -> Fraction:
        """The base tick in s."""
        return self.control_period / self.control_ticks

    @property
    def network_period(self) -> Fraction:
        """T_t in s."""
        return self.control_period * self.ratio

    def delayed(self, forward: Fraction, backward: Fraction) -> Timing:
        """The same with these delays (network samples), to the tick at which they are heard."""
        ways: list[int] = []
        for way in (forward, backward):
            samples, ticks = divmod(math.ceil(way * self.network_ticks), self.network_ticks)
            ways += [samples, ticks]
        return replace(self, delay=PathDelay(ways[0], ways[2], ways[1], ways[3]))

    def refuse_ticks(self) -> None:
        """Refuse a delay between two network samples.

        Raises:
            InputError: it is no whole number of them.
        """
        if not self.delay.is_whole:
            raise InputError(
                "The delay lies between two network samples: this analysis needs whole ones. "
                "Stability and damping (radius, boundary, damping) take any."
            )

    @property
    def has_frame(self) -> bool:
        """Whether one network period takes the loop from sample to sample."""
        return self.ratio.denominator == 1 and self.delay.is_whole

    @property
    def samples_per_frame(self) -> int:
        """N = T_t / T_c, where it is a whole number.

        Raises:
            InputError: where the ratio or the delay is not a whole number.
        """
        self.refuse_ticks()
        if self.ratio.denominator != 1:
            raise InputError(
                f"The ratio {self.ratio} is not a whole number: this analysis needs the network "
                "period to be a multiple of the control period. Stability and damping "
                "(radius, boundary, damping) take any ratio."
            )
        return self.ratio.numerator
