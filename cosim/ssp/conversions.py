"""What happens to a value on its way: from unit to unit, and then a linear transformation."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cosim.base.quantities.units import Unit


@dataclass(frozen=True, slots=True)
class Linear:
    """``factor * value + offset``, exactly."""

    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)

    @staticmethod
    def of(factor: float, offset: float) -> Linear:
        """As it is written."""
        return Linear(Fraction(factor), Fraction(offset))

    def then(self, other: Linear) -> Linear:
        """This one, and the other one of what it gives."""
        return Linear(other.factor * self.factor, other.factor * self.offset + other.offset)

    def behind(self, first: Linear) -> Linear:
        """What is left to do where ``first`` is done already, to come to the same."""
        factor = self.factor / first.factor
        return Linear(factor, self.offset - factor * first.offset)

    @property
    def changes_nothing(self) -> bool:
        """Whether every value stays what it is."""
        return (self.factor, self.offset) == (1, 0)


UNCHANGED = Linear()


def between(source: Unit | None, target: Unit | None) -> Linear:
    """From one unit to another; nothing where one of them is only a name, which says nothing.

    Raises:
        ValueError: the two measure different things.
    """
    if source is None or target is None or source == target:
        return UNCHANGED
    if source.exponents is None or target.exponents is None:
        return UNCHANGED
    if source.exponents != target.exponents:
        raise ValueError(f"it is in {source.name}, which does not convert to {target.name}")
    gain = source.factor / target.factor
    return Linear(gain, (source.offset - target.offset) / target.factor)
