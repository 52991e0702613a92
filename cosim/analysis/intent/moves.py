"""Moves of hands as packets tell of them: recorded ones, cut into pieces, and made ones."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError

Real = NDArray[np.float64]

QUICK, SLOW, CREEPING = (0.25, 0.7), (0.8, 2.0), (3.0, 6.0)
"""How long a reach takes, s."""
COUNT = 2e-5
"""Of an encoder at the tip, m."""
WINDOW = 16
"""Ticks over which a made move's velocity is the difference."""


@dataclass(frozen=True, slots=True)
class Moves:
    """Coordinates of hands at control rate.

    Attributes:
        position: m, shape (ticks, tracks); what a packet would say.
        velocity: m/s, of the same shape.
        period: of the control, s.
        ratio: ticks a packet.
    """

    position: Real
    velocity: Real
    period: float
    ratio: int

    @property
    def halves(self) -> tuple[Moves, Moves]:
        """Every other track each: one half to fit to, one to judge by."""
        return self._of(slice(0, None, 2)), self._of(slice(1, None, 2))

    def _of(self, tracks: slice) -> Moves:
        return Moves(self.position[:, tracks], self.velocity[:, tracks], self.period, self.ratio)


def cut(position: Real, velocity: Real, period: Fraction, ratio: int, length: float = 2.0) -> Moves:
    """Cut long recordings into pieces of equal length.

    Args:
        position: m, shape (ticks, coordinates).
        velocity: m/s, of the same shape.
        period: of the rows, s.
        ratio: rows a packet.
        length: of a piece, s.

    Raises:
        InputError: there are not at least two pieces.
    """
    rows = round(length / float(period)) // ratio * ratio
    pieces = len(position) // rows if rows else 0
    tracks = pieces * position.shape[1]
    if tracks < 2:
        raise InputError(
            f"The recording lasts {len(position) * float(period):.3g} s: two pieces of {length:g} "
            "s are needed, one to fit to and one to judge by."
        )

    def pieces_of(values: Real) -> Real:
        parts = values[: pieces * rows].reshape(pieces, rows, -1)
        return parts.transpose(1, 0, 2).reshape(rows, tracks)

    return Moves(pieces_of(position), pieces_of(velocity), float(period), ratio)


def made(
    duration: tuple[float, float],
    *,
    tremor: float = 0.0,
    tracks: int = 40,
    seed: int = 1,
    length: float = 3.0,
    control_rate: int = 1024,
    ratio: int = 8,
) -> Moves:
    """Minimum-jerk reaches of 3 to 15 cm with rests between them, seen through encoder counts.

    Args:
        duration: shortest and longest of a reach, s; ``QUICK`` or ``SLOW``.
        tremor: amplitude of a sine of 8 to 12 Hz on top, m.
        tracks: how many hands.
        seed: of their reaches.
        length: s.
        control_rate: Hz.
        ratio: ticks a packet.
    """
    draw = np.random.default_rng(seed)
    ticks = int(length * control_rate)
    time = np.arange(-WINDOW, ticks) / control_rate
    true = np.zeros((time.size, tracks))
    for track in range(tracks):
        begin = draw.uniform(0.05, 0.6)
        while begin < length:
            takes = draw.uniform(*duration)
            far = draw.uniform(0.03, 0.15) * draw.choice([-1.0, 1.0])
            s = np.clip((time - begin) / takes, 0.0, 1.0)
            true[:, track] += far * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
            begin += takes + draw.uniform(0.1, 0.6)
        rate, phase = 2 * np.pi * draw.uniform(8.0, 12.0), draw.uniform(0.0, 2 * np.pi)
        true[:, track] += tremor * np.sin(rate * time + phase)
    seen = np.round(true / COUNT) * COUNT
    velocity = (seen[WINDOW:] - seen[:-WINDOW]) * control_rate / WINDOW
    return Moves(seen[WINDOW:], velocity, 1.0 / control_rate, ratio)
