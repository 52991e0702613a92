"""Jitter: extra delay of whole steps, drawn for each packet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, fsum, sqrt
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag

from cosim.base.document.form import Form
from cosim.scenario.form.fields import Delay, Lag, Probability, Span
from cosim.scenario.impairments.effect import (
    Average,
    Draw,
    Effect,
    PacketBlock,
    whole_ticks,
)
from cosim.scenario.impairments.impairment import (
    Dial,
    Impairment,
    ImpairmentProblem,
    Setting,
)

MAX_STEPS = 10_000
ROUNDING = 1e-6
"""Weights that sum to one but for rounding are scaled to do so exactly."""
ONE_SAMPLE = Lag(Fraction(1), "samples")
_EXTRA = 0
"""The purpose of the one draw that a packet needs."""


class RmsJitter(Form):
    """Extra delay of whole base ticks with this standard deviation."""

    rms: Span


class WeightedJitter(Form):
    """Extra delay of i steps with probability weights[i]; the weights sum to one."""

    weights: Annotated[list[Probability], Field(min_length=1, max_length=10_000)]
    step: Delay | None = Field(default=None, description="One step; one sample unless given.")


def _tag(value: Any) -> str:
    """No key of the form that it leads to: a path of findings has tags and keys alike."""
    if not isinstance(value, dict):
        return "plain"
    return "by weights" if "weights" in value else "by rms"


@dataclass(frozen=True, slots=True, kw_only=True)
class Jitter(Effect):
    """Extra delay of ``i * step`` ticks with probability ``weights[i]``; the weights sum to one."""

    order: ClassVar[int] = 10
    own_key: ClassVar[bool] = False
    remembers: ClassVar[bool] = False

    step: int = 1
    weights: tuple[float, ...]

    @property
    def _most(self) -> int:
        return len(self.weights) - 1

    def write(self, period: int) -> Any:
        """A number of samples or ticks where all are as probable, else the weights."""
        if self.weights == uniform(self._most):
            if self.step == period:
                return self._most
            if self.step == 1:
                return f"{self._most} ticks"
        return {"weights": list(self.weights), "step": f"{self.step} ticks"}

    def describe(self) -> int:
        """The most extra delay (ticks)."""
        return self._most * self.step

    def sentence(self) -> str:
        """The most extra delay."""
        most = self._most * self.step
        return f"jitter up to {most} tick{'' if most == 1 else 's'}"

    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """The first weight that is not zero, and the last."""
        first = next(i for i, weight in enumerate(self.weights) if weight > 0)
        return shortest + first * self.step, longest + self._most * self.step

    def draw(self, key: int) -> Draw:
        """The inverse of the distribution function at a uniform draw."""
        import numpy as np

        from cosim.base.counter import draws, thresholds, top_bits

        below = thresholds(_running_sums(self.weights))

        def extra(packets: PacketBlock) -> None:
            drawn = top_bits(draws(key, _EXTRA, packets.first, packets.count))
            index = np.minimum(np.searchsorted(below, drawn, side="right"), self._most)
            packets.delays[packets.arrives] += index[packets.arrives] * self.step

        return extra

    def average(self, before: Average) -> Average:
        """Mean and variance add up."""
        mean, variance = _moments(self.weights)
        return Average(
            delay=before.delay + mean * self.step,
            variance=before.variance + variance * self.step**2,
            lost=before.lost,
        )


def uniform(most: int) -> tuple[float, ...]:
    """Equal weights of 0 to ``most`` steps."""
    return (1.0 / (most + 1),) * (most + 1)


def _resolve(written: Any, setting: Setting) -> Jitter | None:
    match written:
        case RmsJitter(rms=rms):
            step, weights = 1, _weights_of_rms(float(rms * setting.base_rate))
        case WeightedJitter():
            step, weights = _given(written, setting)
        case _:
            step, weights = _up_to(written, setting)
    return Jitter(step=step, weights=weights) if step and len(weights) > 1 else None


def _given(written: WeightedJitter, setting: Setting) -> tuple[int, tuple[float, ...]]:
    total = fsum(written.weights)
    if abs(total - 1.0) > ROUNDING:
        raise ImpairmentProblem(
            f"the weights sum to {total:g}; they are probabilities, which sum to 1."
        )
    scaled = abs(total - 1.0) > 1e-9
    weights = tuple(w / total if scaled else w for w in written.weights)
    return setting.ticks(written.step or ONE_SAMPLE), weights


def _up_to(lag: Lag, setting: Setting) -> tuple[int, tuple[float, ...]]:
    delay = setting.timebase.delay(lag, setting.period)
    step = setting.period if delay.samples is not None else 1
    most = delay.ticks // step
    _check_steps(most)
    return step, uniform(most)


def _weights_of_rms(rms: float) -> tuple[float, ...]:
    """Weights of 0, 1, 2 … ticks with standard deviation ``rms`` (ticks).

    A mixture of the uniform distributions over 0..m-1 and 0..m, for the m that brackets it. A
    uniform distribution over 0..m has the variance ((m + 1)² - 1) / 12.
    """
    if rms == 0.0:
        return (1.0,)
    _check_steps(rms * sqrt(12.0))
    most = max(1, ceil(sqrt(12.0 * rms * rms + 1.0) - 1.0 - 1e-12))
    low, high = 0.0, 1.0
    for _ in range(60):
        share = (low + high) / 2.0
        short = sqrt(_moments(_mixture(most, share))[1]) < rms
        low, high = (share, high) if short else (low, share)
    return _mixture(most, high)


def _mixture(most: int, share: float) -> tuple[float, ...]:
    shorter = (1.0 - share) / most
    return (*(shorter + share / (most + 1),) * most, share / (most + 1))


def _moments(weights: Sequence[float]) -> tuple[float, float]:
    """Mean and variance of the number of steps."""
    mean = fsum(i * weight for i, weight in enumerate(weights))
    return mean, fsum((i - mean) ** 2 * weight for i, weight in enumerate(weights))


def _check_steps(most: float) -> None:
    if most > MAX_STEPS:
        raise ImpairmentProblem(f"it spans more than {MAX_STEPS} steps.")


def _running_sums(weights: Sequence[float]) -> list[float]:
    total, sums = 0.0, list[float]()
    for weight in weights:
        total += weight
        sums.append(total)
    return sums


def _read(effect: Effect | None, base_rate: Fraction) -> float:
    """The most extra delay (s) of a uniform jitter."""
    if effect is None:
        return 0.0
    assert isinstance(effect, Jitter)
    if effect.weights != uniform(len(effect.weights) - 1):
        raise ImpairmentProblem(
            "its weights are no single number that could be turned; write the most that it is, "
            "such as 'jitter: 2 ticks'."
        )
    return float(effect.describe() / base_rate)


def _turn(effect: Effect | None, most: float, base_rate: Fraction) -> Jitter | None:
    """Uniform up to ``most`` (s), in the steps that it had before, or in base ticks."""
    step = effect.step if isinstance(effect, Jitter) else 1
    steps = whole_ticks(most, base_rate) // step
    return Jitter(step=step, weights=uniform(steps)) if steps else None


JITTER = Impairment(
    name="jitter",
    description="Extra delay, uniform from 0 to this.",
    form=Annotated[
        Annotated[Delay, Tag("plain")]
        | Annotated[RmsJitter, Tag("by rms")]
        | Annotated[WeightedJitter, Tag("by weights")],
        Discriminator(_tag),
    ],
    resolve=_resolve,
    absent=0,
    dial=Dial(
        unit="s",
        description="The most extra delay that is drawn for a packet",
        read=_read,
        turn=_turn,
    ),
)
