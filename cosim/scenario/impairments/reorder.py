"""Reorder: packets that are held back, so that later ones pass them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from cosim.scenario.form.fields import Lag
from cosim.scenario.impairments.effect import Average, Draw, Effect, PacketBlock
from cosim.scenario.impairments.impairment import Impairment, Setting
from cosim.scenario.impairments.late import LATE, Late

TWO_SAMPLES = Lag(Fraction(2), "samples")
_HELD_BACK = 3
"""The purpose of the one draw that a packet needs."""


@dataclass(frozen=True, slots=True)
class Reorder(Effect):
    """With ``late.probability`` a packet is held back ``late.ticks`` longer."""

    order: ClassVar[int] = 30
    own_key: ClassVar[bool] = False
    remembers: ClassVar[bool] = False

    late: Late

    def write(self, period: int) -> Any:
        """Probability and delay."""
        return self.late.write()

    def describe(self) -> float:
        """Probability that a packet is held back."""
        return self.late.probability

    def sentence(self) -> str:
        """Probability that a packet is held back."""
        return f"reorder {self.late.probability:.3g}"

    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """A packet may be held back."""
        return shortest, longest + self.late.ticks

    def draw(self, key: int) -> Draw:
        """One draw a packet."""
        from cosim.base.counter import happens

        def hold_back(packets: PacketBlock) -> None:
            held = happens(key, _HELD_BACK, self.late.probability, packets.first, packets.count)
            packets.delays[packets.arrives & held] += self.late.ticks

        return hold_back

    def average(self, before: Average) -> Average:
        """Not counted: a packet that was passed is dropped, as the next one has come already."""
        return before


def _resolve(written: Any, setting: Setting) -> Reorder | None:
    late = Late.of(written, TWO_SAMPLES, setting)
    return None if late is None else Reorder(late)


REORDER = Impairment(
    name="reorder",
    description="Packets held back, two samples.",
    form=LATE,
    resolve=_resolve,
    absent=0.0,
)
