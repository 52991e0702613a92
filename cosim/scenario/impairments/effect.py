"""What an impairment does to the packets of one direction of a channel, once it is resolved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import ceil
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LOST = -1
"""The delay of a packet that never arrives."""

NO_COPY = -1
"""The delay of a second copy that there is not."""


def whole_ticks(seconds: float, base_rate: Fraction) -> int:
    """A time in base ticks: rounded up, unless it was a whole number of them before rounding."""
    ticks = seconds * float(base_rate)
    nearest = round(ticks)
    return nearest if abs(ticks - nearest) <= _ROUNDED * max(1.0, ticks) else ceil(ticks)


@dataclass(slots=True, eq=False)
class PacketBlock:
    """Consecutive packets on their way; an impairment changes the arrays in place."""

    first: int
    """Number of the first packet; a direction's packets are numbered from 0."""
    delays: NDArray[np.int64]
    """Base ticks from sending to arrival, ``LOST`` where it never arrives; shape (n,)."""
    copies: NDArray[np.int64]
    """Base ticks from sending to the arrival of a second copy, ``NO_COPY``; shape (n,)."""

    @property
    def count(self) -> int:
        """Number of packets."""
        return len(self.delays)

    @property
    def arrives(self) -> NDArray[np.bool_]:
        """Which packets arrive, shape (n,)."""
        return self.delays != LOST

    def lose(self, which: NDArray[np.bool_]) -> None:
        """The packets of a mask, shape (n,), never arrive."""
        self.delays[which] = LOST


_ROUNDED = 1e-9
"""What doubles may have lost of a whole number of ticks, relative to it."""

Draw = Callable[[PacketBlock], None]
"""Draws for the next block. Blocks come in order, of any size, and each packet once: what is drawn
may depend on the key and on a packet's number, not on how packets fall into blocks. One that
remembers more from packet to packet offers ``save`` and ``load`` (``cosim.base.resumable``)."""


@dataclass(frozen=True, slots=True)
class Average:
    """A packet's delay on average, for a design that knows delay, jitter and loss alone."""

    delay: float
    """Mean (ticks) of the packets that arrive."""
    variance: float
    """Of the delay (ticks squared)."""
    lost: float
    """Probability that a packet never arrives."""


class Effect(ABC):
    """One impairment of one direction, in base ticks and probabilities; immutable and comparable.

    An impairment that does nothing has no effect: it is left out of the direction.
    """

    __slots__ = ()

    order: ClassVar[int]
    """Effects act in this order: trace 0, jitter 10, loss 20, reorder 30, duplication 40."""
    own_key: ClassVar[bool] = True
    """Whether ``draw`` gets a key of this impairment's own. The five that are built in share the
    key of the direction and number their purposes apart, as records of old have it."""
    remembers: ClassVar[bool] = True
    """Whether a packet's draw may depend on earlier packets. Where it may, and the draw offers no
    ``save`` and ``load``, a run that is restored draws the packets before once more."""

    @abstractmethod
    def write(self, period: int) -> Any:
        """The effect as it may be written in a scenario, with ``period`` ticks to a sample."""

    @abstractmethod
    def describe(self) -> Any:
        """The effect for programs (``check --json``): a number, or plain data (SI units, ticks)."""

    @abstractmethod
    def sentence(self) -> str:
        """The effect for readers (``check``): ``loss 0.2``."""

    @abstractmethod
    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """The shortest delay that a packet, and the longest that a packet or copy can have (ticks).

        The arguments are those without this effect. Packets that are lost do not count.
        """

    @abstractmethod
    def draw(self, key: int) -> Draw:
        """A new stream of draws. ``cosim.base.counter`` has the generator, from ``key``."""

    @abstractmethod
    def average(self, before: Average) -> Average:
        """What the effect makes of a packet's average."""
