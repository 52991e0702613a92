"""What becomes of each packet of a channel: its delay, or that it is lost, and whether it doubles.

The kernel only carries out what is drawn here. A fate depends on the seed, the channel, the
direction, the rate and the packet's number: never on the order of components, on the size of a
block, or on what other channels do.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.counter import stream_key
from cosim.base.resumable import Resumable
from cosim.scenario import Direction
from cosim.scenario.impairments.effect import LOST, NO_COPY, Draw, Effect, PacketBlock

__all__ = ["LOST", "NO_COPY", "FateStream", "Fates", "fates_of"]

_AGAIN = 1 << 16
"""Packets that are drawn again at a time."""


@dataclass(frozen=True, slots=True)
class Fates:
    """What one direction of a channel does to its packets at one rate; each run draws by itself."""

    direction: Direction
    """As it is written; a stream may be turned to another one."""
    key: int
    extremes: tuple[Direction, ...] = ()
    """The direction with everything that may be turned at its least, and at its most."""
    path: tuple[str, ...] = ()
    """Channel, way and rate: with the seed, what the key is made of."""

    def again(self, seed: int, direction: Direction, extremes: tuple[Direction, ...]) -> Fates:
        """The same stream of another run."""
        return Fates(direction, stream_key(seed, *self.path), extremes, self.path)

    @property
    def shortest(self) -> int:
        """The shortest delay that a packet of this stream can have (ticks)."""
        return self._range()[0]

    @property
    def longest(self) -> int:
        """The longest delay that a packet or its second copy can have (ticks)."""
        return self._range()[1]

    @property
    def is_constant(self) -> bool:
        """Whether every packet arrives, all with the same delay."""
        return not any(each.impairments for each in (self.direction, *self.extremes))

    def has_ways_of(self, other: Fates) -> bool:
        """Whether packets fare alike there, by other draws at most."""
        same = self.direction is other.direction or self.direction == other.direction
        return same and self.extremes == other.extremes

    def begin(self) -> FateStream:
        """The stream from its first packet on."""
        return FateStream(self)

    def draw(self, name: str, effect: Effect) -> Draw:
        """An impairment's draw at its first packet."""
        return effect.draw(stream_key(self.key, name) if effect.own_key else self.key)

    def _range(self) -> tuple[int, int]:
        ranges = [_range_of(each) for each in (self.direction, *self.extremes)]
        return min(low for low, _ in ranges), max(high for _, high in ranges)


class FateStream:
    """The fates of a direction's packets as one run draws them.

    Blocks must be asked for in order: what is drawn may depend on earlier packets.
    """

    __slots__ = ("_direction", "_draws", "_next", "fates")

    def __init__(self, fates: Fates) -> None:
        self.fates = fates
        self._direction = fates.direction
        self._draws: list[Draw] = []
        self._next = 0

    def save(self) -> dict[str, Any]:
        """How many packets were drawn, and what their draws remember, by impairment."""
        kept = zip(_effects(self._direction), self._draws, strict=False)
        return {
            "next": self._next,
            "draws": {name: draw.save() for (name, _), draw in kept if isinstance(draw, Resumable)},
        }

    def load(self, values: Any) -> None:
        """Go on from what ``save`` returned.

        Raises:
            KeyError, TypeError, ValueError: these are not values of this stream.
        """
        drawn, kept = int(values["next"]), values["draws"]
        self._next = 0
        if drawn == 0:
            return
        self._begin()
        named = list(zip(_effects(self._direction), self._draws, strict=True))
        forgetful = [
            name
            for (name, effect), draw in named
            if effect.remembers and not isinstance(draw, Resumable)
        ]
        while forgetful and self._next < drawn:
            self.take(min(drawn - self._next, _AGAIN))
        self._next = drawn
        for (name, _), draw in zip(_effects(self._direction), self._draws, strict=True):
            if isinstance(draw, Resumable):
                draw.load(kept[name])

    def turn(self, direction: Direction, packet: int | None = None) -> None:
        """Draw by another direction, from a packet on or from the one that is next.

        A draw that remembers earlier packets draws them once more: of what it remembers nothing
        depends on what may be turned.
        """
        self._direction = direction
        if packet is None:
            return
        self._next = 0
        if any(effect.remembers for _, effect in _effects(direction)):
            while self._next < packet:
                self.take(min(packet - self._next, _AGAIN))
        elif packet:
            self._begin()
            self._next = packet

    def take(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The delays (ticks, -1 lost) of the next packets and of their copies (-1 none)."""
        if self._next == 0:
            self._begin()
        first, self._next = self._next, self._next + count
        delays = np.full(count, self._direction.delay.ticks, dtype=np.int64)
        packets = PacketBlock(first, delays, np.full(count, NO_COPY, dtype=np.int64))
        for draw in self._draws:
            draw(packets)
        return packets.delays, packets.copies

    def _begin(self) -> None:
        effects = _effects(self._direction)
        self._draws = [self.fates.draw(name, effect) for name, effect in effects]


def _effects(direction: Direction) -> list[tuple[str, Effect]]:
    """The impairments with their names, in the order in which they act."""
    return sorted(direction.impairments.items(), key=lambda entry: (entry[1].order, entry[0]))


def _range_of(direction: Direction) -> tuple[int, int]:
    shortest = longest = direction.delay.ticks
    for _, effect in _effects(direction):
        shortest, longest = effect.range(shortest, longest)
    return shortest, longest


def fates_of(
    seed: int,
    channel: str,
    way: str,
    rate: Fraction,
    direction: Direction,
    *,
    extremes: tuple[Direction, ...] = (),
) -> Fates:
    """The stream of one direction (``forward`` or ``backward``) of a channel at one rate (Hz)."""
    path = channel, way, str(rate)
    return Fates(direction, stream_key(seed, *path), extremes, path)
