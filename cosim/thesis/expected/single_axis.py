"""An independent computation of two users on one axis, in plain Python: the limits' predictions.

User 1's hand is prescribed as a sine, user 2's is a free mass or not there; both copies of the
object are masses under held forces, with dry friction of the ground where there is any. Nothing
else of the product is used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

T_C = 1.0 / 1024.0
RATIO = 8

Gains = tuple[float, float]
"""Stiffness and damping."""


@dataclass(frozen=True, slots=True)
class TwoCopies:
    """Two copies on one axis, in N/m or N·m/rad.

    ``friction`` (N, N·m) is the ground's on each copy; ``hand`` is ``None`` where user 2 is away.
    """

    mass: float = 0.4
    hand: float | None = 0.1
    local: Gains = (800.0, 3.0)
    remote: Gains = (170.0, 3.0)
    between: Gains = (77.5, 10.0)
    friction: float = 0.0
    amplitude: float = 0.05
    frequency: float = 2.0


LINEAR = TwoCopies()
"""The free motion of figure 8.3, along the normal."""

ON_THE_TABLE = TwoCopies(friction=0.05 * 0.4 * 9.81)
"""The same with section 8.1's friction: 0.196 N on each copy."""

TURNING = TwoCopies(
    mass=6.7e-4,
    hand=None,
    local=(2 * 1200 * 0.05**2, 2 * 10 * 0.05**2),
    remote=(2 * 270 * 0.05**2, 2 * 5 * 0.05**2),
    between=(2.2, 0.05),
    amplitude=0.15,
    frequency=4.0,
)
"""Two fingers at half the side turn the box to and fro; lengths become angles, masses inertia."""


@dataclass(slots=True)
class _Body:
    position: float = 0.0
    velocity: float = 0.0

    def step(self, force: float, mass: float, friction: float = 0.0) -> None:
        """Exact under a held force; dry friction takes what it can of the velocity first."""
        speed = abs(self.velocity + T_C * force / mass)
        slowed = max(0.0, 1.0 - T_C * friction / mass / speed) if speed > 0.0 else 1.0
        after = (self.velocity + T_C * force / mass) * slowed
        self.position += 0.5 * T_C * (self.velocity + after)
        self.velocity = after


def net_force_amplitude(
    round_trip: int, compensation: float, axis: TwoCopies = LINEAR, seconds: float = 20.0
) -> float:
    """Amplitude (N, N·m) at the sine's frequency of both users' forces on their copies, added up.

    Args:
        round_trip: in network samples, the half that is left over on the way from user 1.
        compensation: on both copies (N·s/m, N·m·s/rad), negative where it pushes.
        axis: gains and masses.
        seconds: of motion; the last three periods count.
    """
    forward, backward = (round_trip + 1) // 2, round_trip // 2
    ticks = int(seconds / T_C)
    one, two, hand = _Body(), _Body(), _Body()
    net = np.zeros(ticks)
    up: list[tuple[float, float, float, float]] = []
    down: list[tuple[float, float, float, float]] = []
    held_1 = held_2 = (0.0, 0.0, 0.0, 0.0)
    for k in range(ticks):
        angle = axis.frequency * k * T_C
        driven = axis.amplitude * math.sin(angle)
        speed = axis.amplitude * axis.frequency * math.cos(angle)
        if k % RATIO == 0:
            up.append((driven, speed, one.position, one.velocity))
            down.append((hand.position, hand.velocity, two.position, two.velocity))
            held_1 = down[max(len(down) - 1 - backward, 0)]
            held_2 = up[max(len(up) - 1 - forward, 0)]
        first = _pull(axis.local, driven, speed, one)
        second = 0.0
        if axis.hand is not None:
            second = _pull(axis.local, hand.position, hand.velocity, two)
        net[k] = first + second
        force_1 = first + _pull(axis.between, *held_1[2:], one) - compensation * one.velocity
        force_2 = second + _pull(axis.between, *held_2[2:], two) - compensation * two.velocity
        force_2 += _pull(axis.remote, *held_2[:2], two)
        if axis.hand is not None:
            force_1 += _pull(axis.remote, *held_1[:2], one)
            hand.step(-second, axis.hand)
        one.step(force_1, axis.mass, axis.friction)
        two.step(force_2, axis.mass, axis.friction)
    window = int(2 * math.pi / axis.frequency * 3 / T_C)
    phase = axis.frequency * T_C * np.arange(ticks - window, ticks)
    basis = np.stack([np.ones(window), np.cos(phase), np.sin(phase)], axis=1)
    fit = np.linalg.lstsq(basis, net[-window:], rcond=None)[0]
    return float(np.hypot(fit[1], fit[2]))


def _pull(gains: Gains, towards: float, speed: float, own: _Body) -> float:
    return gains[0] * (towards - own.position) + gains[1] * (speed - own.velocity)
