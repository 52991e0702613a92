"""One finger against a box before a wall, in plain Python: with impulses (7.1, 7.2) and without.

Two masses on one axis: hand and device, and the box. Nothing of the product is used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cosim.thesis.expected.single_axis import T_C
from cosim.thesis.expected.statics import GROUND, JOINTS, LOCAL_NORMAL, MASS

HAND_MASS = 0.1
PUSH = 0.5
WAY = 0.01
"""From rest to the face (m)."""
DAMPING = 3.0
WALL, WALL_DAMPING = 2 * 4000.0, 2 * 30.0
"""Under two corners (N/m, N·s/m)."""
IMPULSE_FORCE = 2.5


@dataclass(frozen=True, slots=True)
class Impact:
    """How deep the hand comes (m), and how often the contact's state changes."""

    deepest: float
    changes: int


def impact(*, impulses: bool, seconds: float = 2.0) -> Impact:
    """The hand is pushed from rest into the box and pushes on."""
    hand, hand_speed = -WAY, 0.0
    box, box_speed = 0.0, 0.0
    deepest, changes = 0.0, 0
    state, left = "free", 0
    for _ in range(int(seconds / T_C)):
        depth, approach = hand - box, hand_speed - box_speed
        before = state
        if depth <= 0.0:
            state = "free"
        elif state == "free":
            left = int(HAND_MASS * approach / (T_C * IMPULSE_FORCE)) if impulses else 0
            state = "impulses" if left > 0 and approach > 0.0 else "sticks"
        elif state == "impulses" and not (left > 0 and approach > 0.0):
            state = "sticks"
        force = 0.0
        if state == "impulses":
            left -= 1
            force = IMPULSE_FORCE
        elif state == "sticks":
            force = max(0.0, LOCAL_NORMAL * depth + DAMPING * approach)
        changes += state != before
        hand_speed = _slowed(hand_speed + T_C * (PUSH - force) / HAND_MASS, JOINTS / HAND_MASS)
        hand += T_C * hand_speed
        wall = WALL * box + WALL_DAMPING * box_speed if box > 0.0 else 0.0
        box_speed = _slowed(box_speed + T_C * (force - max(0.0, wall)) / MASS, GROUND / MASS)
        box += T_C * box_speed
        deepest = max(deepest, hand)
    return Impact(deepest, changes)


def _slowed(speed: float, friction: float) -> float:
    """After dry friction (m/s²) of one tick."""
    return math.copysign(max(0.0, abs(speed) - T_C * friction), speed)
