"""Joint angles that tell a five-bar's parameters apart: two bands of sines about one pose.

Slow sines of equal amplitude go through many poses, fast ones of equal acceleration push against
inertia rather than friction (a band-limited multisine: Swevers et al., "Optimal robot excitation
and identification", IEEE T-RA 13, 1997). They rise and fall smoothly, after a move from the pose
where the handle was found, so that nothing jumps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cosim.identification.five_bar import Array

SLOW_BAND = (0.25, 1.5)
FAST_BAND = (3.0, 15.0)
"""Hz."""
SLOW_SINES, FAST_SINES = 6, 30
STILL, MOVE, RISE, FALL, REST = 0.5, 2.0, 1.5, 1.0, 0.5
"""Seconds before the move to the middle, of it, of rising, of falling, and at the end."""
OVERHEAD = STILL + MOVE + RISE + FALL + REST
"""Seconds of a trajectory that are none of its excitation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """``middle`` (rad) is what it goes about, ``slow`` (rad) and ``fast`` (rad/s2) its peaks.

    ``seconds`` is how long it excites at full size; the same ``seed`` gives the same sines.
    """

    middle: tuple[float, float]
    slow: float
    fast: float
    seconds: float
    seed: int = 1

    @property
    def duration(self) -> float:
        """All of it (s)."""
        return self.seconds + OVERHEAD

    def sampled(self, start: Array, tick: float) -> tuple[Array, Array, Array]:
        """Angles, rates and accelerations (rows, 2) from ``start`` (rad), a row a ``tick`` (s)."""
        at = np.arange(round(self.duration / tick) + 1) * tick
        begin = STILL + MOVE
        angle, rate, acceleration = _blend((at - STILL) / MOVE, MOVE)
        away = np.asarray(self.middle) - start
        paths = [start + np.outer(angle, away), np.outer(rate, away), np.outer(acceleration, away)]
        rises = _blend((at - begin) / RISE, RISE)
        falls = _blend((begin + RISE + self.seconds + FALL - at) / FALL, -FALL)
        up, faster, bend = _product(rises, falls)
        waves = self._waves(at - begin)
        paths[0] += up[:, None] * waves[0]
        paths[1] += up[:, None] * waves[1] + faster[:, None] * waves[0]
        paths[2] += (
            up[:, None] * waves[2] + 2 * faster[:, None] * waves[1] + bend[:, None] * waves[0]
        )
        return paths[0], paths[1], paths[2]

    def _waves(self, at: Array) -> tuple[Array, Array, Array]:
        slow, fast = _unit_waves(self.seed, len(at), float(at[0]), float(at[1] - at[0]))
        found = [self.slow * one + self.fast * other for one, other in zip(slow, fast, strict=True)]
        return found[0], found[1], found[2]


@lru_cache(maxsize=2)
def _unit_waves(
    seed: int, rows: int, start: float, tick: float
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Angles, rates and accelerations of the slow part at peak 1 rad and the fast at 1 rad/s2."""
    chance = np.random.default_rng(seed)
    at = start + np.arange(rows) * tick
    found: list[tuple[Array, Array, Array]] = []
    for band, order, number in ((SLOW_BAND, 0, SLOW_SINES), (FAST_BAND, 2, FAST_SINES)):
        waves = tuple(np.zeros((rows, 2)) for _ in range(3))
        slot = (band[1] - band[0]) / number
        for joint in (0, 1):
            # Each sine lies anywhere in its slot, so that nothing repeats, counts included.
            turns = 2 * np.pi * (band[0] + slot * (np.arange(number) + chance.random(number)))
            for turn, phase in zip(turns, chance.uniform(0, 2 * np.pi, number), strict=True):
                size, place = turn**-order, turn * at + phase
                sine, cosine = np.sin(place), np.cos(place)
                waves[0][:, joint] += size * sine
                waves[1][:, joint] += size * turn * cosine
                waves[2][:, joint] -= size * turn**2 * sine
        peak = np.max(np.abs(waves[order]), axis=0)
        found.append((waves[0] / peak, waves[1] / peak, waves[2] / peak))
    return found[0], found[1]


def _blend(share: Array, seconds: float) -> tuple[Array, Array, Array]:
    """0 to 1 with minimum jerk over a share from 0 to 1 that takes ``seconds``; derivatives."""
    s = np.clip(share, 0.0, 1.0)
    return (
        s**3 * (10 - 15 * s + 6 * s**2),
        30 * s**2 * (1 - s) ** 2 / seconds,
        60 * s * (1 - s) * (1 - 2 * s) / seconds**2,
    )


def _product(
    one: tuple[Array, Array, Array], other: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    return (
        one[0] * other[0],
        one[1] * other[0] + one[0] * other[1],
        one[2] * other[0] + 2 * one[1] * other[1] + one[0] * other[2],
    )
