"""The five-bar's motion for whole arrays of samples, from its two constraints alone.

Each distal link joins an elbow E_i to the tip P at a fixed length: |P - E_i| = L. Differentiated
once and twice in time that gives the tip's velocity and acceleration from the elbows', a 2 x 2
system each. Geometry: G. Campion, Q. Wang, V. Hayward, "The Pantograph Mk-II", IROS 2005.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
"""Of floats, as NumPy's own functions return them."""


@dataclass(frozen=True, slots=True)
class MovedBar:
    """Places, velocities and accelerations of samples, each of shape (samples, 2), SI units.

    ``elbow[i]`` is the end of proximal link i. ``jacobian`` (samples, 2, 2) maps joint rates to the
    tip's velocity, ``elbow_jacobian[i]`` (samples, 2) the rate of joint i to its elbow's.
    """

    tip: Array
    tip_velocity: Array
    tip_acceleration: Array
    elbow: tuple[Array, Array]
    elbow_velocity: tuple[Array, Array]
    elbow_acceleration: tuple[Array, Array]
    jacobian: Array
    elbow_jacobian: tuple[Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class FiveBar:
    """Link lengths and motor distance (m); motors at (0, 0) and (base, 0), the tip above."""

    proximal: float
    distal: float
    base: float

    def motion(self, angle: Array, rate: Array, acceleration: Array) -> MovedBar:
        """What moves how, for joint angles, rates and accelerations of shape (samples, 2).

        Where the links cannot meet the result is NaN.
        """
        elbows: list[Array] = []
        swings: list[Array] = []
        velocities: list[Array] = []
        accelerations: list[Array] = []
        for joint, axis in enumerate((0.0, self.base)):
            turned, turns = angle[:, joint], rate[:, joint, None]
            out = self.proximal * np.stack([np.cos(turned), np.sin(turned)], axis=1)
            swing = np.stack([-out[:, 1], out[:, 0]], axis=1)
            elbows.append(out + np.array([axis, 0.0]))
            swings.append(swing)
            velocities.append(swing * turns)
            accelerations.append(swing * acceleration[:, joint, None] - out * turns**2)
        tip = self._tip(*elbows)
        links = [tip - elbow for elbow in elbows]
        jacobian = np.stack(
            [
                _solve(links, *(_dot(link, swing) * (joint == i) for i, link in enumerate(links)))
                for joint, swing in enumerate(swings)
            ],
            axis=2,
        )
        pairs = list(zip(links, velocities, strict=True))
        velocity = _solve(links, *(_dot(link, moves) for link, moves in pairs))
        turning = [velocity - moves for moves in velocities]
        tip_acceleration = _solve(
            links,
            *(
                _dot(link, gains) - _dot(turn, turn)
                for link, gains, turn in zip(links, accelerations, turning, strict=True)
            ),
        )
        return MovedBar(
            tip=tip,
            tip_velocity=velocity,
            tip_acceleration=tip_acceleration,
            elbow=(elbows[0], elbows[1]),
            elbow_velocity=(velocities[0], velocities[1]),
            elbow_acceleration=(accelerations[0], accelerations[1]),
            jacobian=jacobian,
            elbow_jacobian=(swings[0], swings[1]),
        )

    def tip(self, angle: Array) -> Array:
        """Tip positions (samples, 2) in metres for joint angles (samples, 2) in rad."""
        still = np.zeros_like(angle)
        return self.motion(angle, still, still).tip

    def angles(self, tip: Array) -> Array:
        """Joint angles (samples, 2) for tips (samples, 2), elbows outward, 0 to 2 pi.

        NaN where a tip is out of reach.
        """
        found: list[Array] = []
        for axis, side in ((0.0, 1.0), (self.base, -1.0)):
            out = tip - np.array([axis, 0.0])
            reach = np.hypot(out[:, 0], out[:, 1])
            with np.errstate(invalid="ignore", divide="ignore"):
                bend = (self.proximal**2 + reach**2 - self.distal**2) / (2 * self.proximal * reach)
                turned = np.arctan2(out[:, 1], out[:, 0]) + side * np.arccos(bend)
            found.append(turned % (2 * np.pi))
        return np.stack(found, axis=1)

    def dexterity(self, angle: Array) -> Array:
        """The least sine of the angles between the links, shape (samples,): 0 where singular."""
        still = np.zeros_like(angle)
        seen = self.motion(angle, still, still)
        links = [(seen.tip - elbow) / self.distal for elbow in seen.elbow]
        arms = [swing / self.proximal for swing in seen.elbow_jacobian]
        sines = [np.abs(links[0][:, 0] * links[1][:, 1] - links[0][:, 1] * links[1][:, 0])]
        sines += [np.abs(_dot(link, arm)) for link, arm in zip(links, arms, strict=True)]
        return np.min(sines, axis=0)

    def _tip(self, first: Array, second: Array) -> Array:
        across = second - first
        gap = np.hypot(across[:, 0], across[:, 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            height = np.sqrt(self.distal**2 - gap**2 / 4) / gap
        upright = np.stack([-across[:, 1], across[:, 0]], axis=1)
        return first + across / 2 + height[:, None] * upright


def _dot(one: Array, other: Array) -> Array:
    return np.einsum("si,si->s", one, other)


def _solve(links: list[Array], first: Array, second: Array) -> Array:
    """The vectors v (samples, 2) with link_1 . v = first and link_2 . v = second."""
    one, two = links
    determinant = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.stack(
            [
                (first * two[:, 1] - second * one[:, 1]) / determinant,
                (second * one[:, 0] - first * two[:, 0]) / determinant,
            ],
            axis=1,
        )
