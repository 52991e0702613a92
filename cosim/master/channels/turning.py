"""Channels whose delay, jitter or loss is turned: from their dials' cells to packets' fates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.layout import Layout
from cosim.master.channels.packets import Packets
from cosim.scenario import Direction
from cosim.scenario.build.dials import turned

Way = tuple[str, str]
"""A channel, and ``forward`` or ``backward``."""


@dataclass(slots=True)
class TurnedChannels:
    """The directions that have dials; a dial's cell holds its value in force, in SI units."""

    packets: Packets
    base_rate: Fraction
    cells: NDArray[np.float64]
    dials: Mapping[Way, Mapping[str, int]]
    """The cell of each dial, by name."""
    bundles: dict[Way, list[int]] = field(init=False)

    def __post_init__(self) -> None:
        self.bundles = {
            way: [n for n, b in enumerate(self.packets.bundles) if (b.channel, b.way) == way]
            for way in self.dials
        }

    def carry_out(self, way: Way) -> None:
        """A dial was turned: packets that are sent from now on go by it."""
        for number in self.bundles[way]:
            self.packets.turn(number, self._direction(way, number))

    def take_back(self) -> None:
        """The cells are those of a snapshot: so is what is in force."""
        for way, numbers in self.bundles.items():
            for number in numbers:
                self.packets.take_back(number, self._direction(way, number))

    def _direction(self, way: Way, number: int) -> Direction:
        standing = {name: float(self.cells[cell]) for name, cell in self.dials[way].items()}
        return turned(self.packets.bundles[number].fates.direction, standing, self.base_rate)


def dials_of(names: Sequence[tuple[str, str]], layout: Layout) -> dict[Way, dict[str, int]]:
    """The dials among knobs' names (``forward.delay``), by channel and way."""
    found: dict[Way, dict[str, int]] = {}
    for channel, dial in names:
        way, _, name = dial.partition(".")
        found.setdefault((channel, way), {})[name] = layout.cells[channel, dial]
    return found
