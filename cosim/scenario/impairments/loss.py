"""Loss: packets that never arrive, each by itself or in bursts."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Tag

from cosim.base.document.form import Form, mapping_tag
from cosim.scenario.form.fields import Probability
from cosim.scenario.impairments.effect import Average, Draw, Effect, PacketBlock
from cosim.scenario.impairments.impairment import (
    Dial,
    Impairment,
    ImpairmentProblem,
    Setting,
)

_LOSS, _STATE, _STATIONARY = 1, 2, 5
"""Purposes of the draws: a packet's loss, the chain's move after it, the state it begins in."""


class GilbertElliottForm(Form):
    """Loss in bursts: a chain of a good and a bad state that moves once a packet."""

    good_to_bad: Probability
    bad_to_good: Probability
    loss_good: Probability = 0.0
    loss_bad: Probability = 1.0


class _Loss(Effect):
    """What both kinds of loss have in common: delays stay, and so many never arrive."""

    __slots__ = ()
    order: ClassVar[int] = 20
    own_key: ClassVar[bool] = False

    @property
    def share(self) -> float:
        """Probability that a packet is lost."""
        raise NotImplementedError

    def describe(self) -> float:
        """Probability that a packet is lost."""
        return self.share

    def sentence(self) -> str:
        """Probability that a packet is lost."""
        return f"loss {self.share:.3g}"

    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """What arrives has the delay that it would have."""
        return shortest, longest

    def average(self, before: Average) -> Average:
        """What arrives has the delay that it would have."""
        lost = self.share if before.lost == 0.0 else 1.0 - (1.0 - before.lost) * (1.0 - self.share)
        return Average(before.delay, before.variance, lost)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bernoulli(_Loss):
    """Each packet is lost with probability ``probability``, independently."""

    remembers: ClassVar[bool] = False

    probability: float

    @property
    def share(self) -> float:
        """Probability that a packet is lost."""
        return self.probability

    def write(self, period: int) -> float:
        """The probability."""
        return self.probability

    def draw(self, key: int) -> Draw:
        """One draw a packet."""
        from cosim.base.counter import happens

        def lose(packets: PacketBlock) -> None:
            packets.lose(happens(key, _LOSS, self.probability, packets.first, packets.count))

        return lose


@dataclass(frozen=True, slots=True, kw_only=True)
class GilbertElliott(_Loss):
    """Bursty loss: a two-state Markov chain that moves once a packet, each state with its own loss.

    The chain starts in its stationary distribution. Source: Gilbert (1960), Elliott (1963).
    """

    good_to_bad: float
    bad_to_good: float
    loss_good: float = 0.0
    loss_bad: float = 1.0

    @property
    def share(self) -> float:
        """Probability that a packet is lost."""
        return (1.0 - self._bad) * self.loss_good + self._bad * self.loss_bad

    @property
    def _bad(self) -> float:
        return self.good_to_bad / (self.good_to_bad + self.bad_to_good)

    def write(self, period: int) -> dict[str, float]:
        """Every member."""
        return {
            "good_to_bad": self.good_to_bad,
            "bad_to_good": self.bad_to_good,
            "loss_good": self.loss_good,
            "loss_bad": self.loss_bad,
        }

    def draw(self, key: int) -> Draw:
        """A packet is lost as the state says; the chain moves after it."""
        from cosim.base.counter import happens

        return _Chain(self, key, is_bad=bool(happens(key, _STATIONARY, self._bad, 0, 1)[0]))


class _Chain:
    """The draws of a Gilbert–Elliott chain, and the state that it is in."""

    def __init__(self, loss: GilbertElliott, key: int, *, is_bad: bool) -> None:
        self._loss, self._key, self._is_bad = loss, key, is_bad

    def __call__(self, packets: PacketBlock) -> None:
        import numpy as np

        from cosim.base.counter import happens

        loss, key, bad = self._loss, self._key, self._is_bad
        block = packets.first, packets.count
        worsens = happens(key, _STATE, loss.good_to_bad, *block).tolist()
        recovers = happens(key, _STATE, loss.bad_to_good, *block).tolist()
        states = np.zeros(packets.count, dtype=np.bool_)
        for i in range(packets.count):
            states[i] = bad
            bad = not recovers[i] if bad else worsens[i]
        self._is_bad = bad
        when_bad = happens(key, _LOSS, loss.loss_bad, *block)
        when_good = happens(key, _LOSS, loss.loss_good, *block)
        packets.lose(np.where(states, when_bad, when_good))

    def save(self) -> bool:
        """Whether the chain is in its bad state."""
        return self._is_bad

    def load(self, values: Any) -> None:
        """Go on from that state."""
        if not isinstance(values, bool):
            raise TypeError("the state of a Gilbert–Elliott chain is true or false")
        self._is_bad = values


def _resolve(written: Any, _: Setting) -> Bernoulli | GilbertElliott | None:
    if not isinstance(written, GilbertElliottForm):
        return Bernoulli(probability=written) if written else None
    if written.good_to_bad == written.bad_to_good == 0.0:
        raise ImpairmentProblem("good_to_bad and bad_to_good are both 0: the chain is stuck.")
    return GilbertElliott(
        good_to_bad=written.good_to_bad,
        bad_to_good=written.bad_to_good,
        loss_good=written.loss_good,
        loss_bad=written.loss_bad,
    )


def _read(effect: Effect | None, _: Fraction) -> float:
    """The probability of loss of each packet."""
    if effect is None:
        return 0.0
    if not isinstance(effect, Bernoulli):
        raise ImpairmentProblem(
            "it comes in bursts, which are no single number that could be turned; write a "
            "probability, such as 'loss: 2 %'."
        )
    return effect.probability


def _turn(_: Effect | None, probability: float, __: Fraction) -> Bernoulli | None:
    """Each packet by itself."""
    return Bernoulli(probability=probability) if probability else None


LOSS = Impairment(
    name="loss",
    description="Probability of loss, or bursts.",
    form=Annotated[
        Annotated[Probability, Tag("plain")] | Annotated[GilbertElliottForm, Tag("mapping")],
        Discriminator(mapping_tag),
    ],
    resolve=_resolve,
    absent=0.0,
    dial=Dial(
        unit="1",
        description="Probability that a packet is lost",
        read=_read,
        turn=_turn,
    ),
)
