"""A measured network as the theory sees it: delay, jitter and loss become a packet process."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.chance.packets import LinkProcess, bernoulli, check_probability, random_delay
from cosim.theory.numerics import gamma_distribution

LONGEST_SPREAD = 12
"""Delays beyond so many samples are put together: the chain grows with its square."""


@dataclass(frozen=True, slots=True)
class Network:
    """What a network characterisation says, per direction.

    Attributes:
        period: T_t in s.
        delay: mean one-way delay in s.
        jitter: RMS jitter of the one-way delay in s.
        loss: probability that a packet is lost.
    """

    period: Fraction
    delay: float
    jitter: float
    loss: float

    def __post_init__(self) -> None:
        """Refuse what no network does.

        Raises:
            InputError: for negative times, or a loss that is no probability below 1.
        """
        check_probability("loss", self.loss)
        if self.loss >= 1:
            raise InputError("A network that loses every packet connects nobody.")
        for name, value in (("delay", self.delay), ("jitter", self.jitter)):
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"The {name} is {value:g} s: it cannot be negative.")

    @property
    def fixed_delay(self) -> int:
        """The mean delay in whole network samples, rounded up."""
        return math.ceil(self.delay / float(self.period) - 1e-9)

    def process(self) -> LinkProcess:
        """The packet process of one direction.

        The delay follows a gamma distribution with the measured mean and deviation (no packet
        arrives before it is sent), rounded up to whole samples, because what arrives within a
        frame is used from the next one on.
        """
        if self.jitter == 0.0:
            return bernoulli(self.loss, self.fixed_delay)
        probabilities = self.delay_probabilities()
        if max(probabilities) == 1.0:
            return bernoulli(self.loss, len(probabilities) - 1)
        return random_delay(probabilities, self.loss)

    def delay_probabilities(self) -> list[float]:
        """Probability of a delay of 0, 1, 2 … samples."""
        period = float(self.period)
        longest = min(math.ceil((self.delay + 6 * self.jitter) / period), LONGEST_SPREAD)
        edges = np.arange(longest) * period
        below = [*(self._arrived_by(float(edge)) for edge in edges), 1.0]
        probabilities = np.diff([0.0, *below])
        probabilities[probabilities < 3e-4] = 0.0
        last = int(np.max(np.nonzero(probabilities)))
        kept = probabilities[: last + 1] / probabilities.sum()
        return [float(value) for value in kept]

    def _arrived_by(self, time: float) -> float:
        """Probability that a packet has arrived within ``time`` of being sent."""
        if self.delay == 0.0:
            return math.erf(time / (self.jitter * math.sqrt(2.0)))
        return gamma_distribution(time, mean=self.delay, deviation=self.jitter)

    def without(self, impairment: str) -> Network:
        """The same network without its loss, jitter or delay."""
        return Network(
            self.period,
            0.0 if impairment == "delay" else self.delay,
            0.0 if impairment in {"jitter", "delay"} else self.jitter,
            0.0 if impairment == "loss" else self.loss,
        )
