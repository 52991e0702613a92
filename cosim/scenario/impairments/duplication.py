"""Duplication: packets that arrive a second time."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from cosim.scenario.form.fields import Lag
from cosim.scenario.impairments.effect import Average, Draw, Effect, PacketBlock
from cosim.scenario.impairments.impairment import Impairment, Setting
from cosim.scenario.impairments.late import LATE, Late

ONE_SAMPLE = Lag(Fraction(1), "samples")
_DOUBLED = 4
"""The purpose of the one draw that a packet needs."""


@dataclass(frozen=True, slots=True)
class Duplication(Effect):
    """With ``late.probability`` a packet arrives a second time, ``late.ticks`` after the first."""

    order: ClassVar[int] = 40
    own_key: ClassVar[bool] = False
    remembers: ClassVar[bool] = False

    late: Late

    def write(self, period: int) -> Any:
        """Probability and delay."""
        return self.late.write()

    def describe(self) -> float:
        """Probability that a packet comes twice."""
        return self.late.probability

    def sentence(self) -> str:
        """Probability that a packet comes twice."""
        return f"duplication {self.late.probability:.3g}"

    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """The copy is later."""
        return shortest, longest + self.late.ticks

    def draw(self, key: int) -> Draw:
        """One draw a packet."""
        from cosim.base.counter import happens

        def double(packets: PacketBlock) -> None:
            drawn = happens(key, _DOUBLED, self.late.probability, packets.first, packets.count)
            doubled = packets.arrives & drawn
            packets.copies[doubled] = packets.delays[doubled] + self.late.ticks

        return double

    def average(self, before: Average) -> Average:
        """Second copies are dropped."""
        return before


def _resolve(written: Any, setting: Setting) -> Duplication | None:
    late = Late.of(written, ONE_SAMPLE, setting)
    return None if late is None else Duplication(late)


DUPLICATION = Impairment(
    name="duplication",
    description="Packets that come twice.",
    form=LATE,
    resolve=_resolve,
    absent=0.0,
)
