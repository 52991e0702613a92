"""What a steady grasp can do at most: bounds from statics, without any simulation.

All values are those of the scenarios in ``scenarios/thesis`` and of the Quanser-like device (SI).
"""

from __future__ import annotations

import math

HAND = 100.0
"""Stiffness of a relaxed hand (N/m)."""
LOCAL_NORMAL, LOCAL_TANGENTIAL = 800.0, 1200.0
REMOTE_NORMAL, REMOTE_TANGENTIAL = 170.0, 270.0
BETWEEN = 77.5
"""K_o (N/m)."""
MASS = 0.4
GROUND = 0.05 * MASS * 9.81
"""Dry friction of the ground on one copy (N)."""
JOINTS = math.sqrt(2.0) * 3e-3 / 0.1
"""What both joints' dry friction holds at a tip (N)."""
STICKS = 0.6
"""Friction of a finger on the box."""
SQUEEZE = 2.25
"""What a finger of the two users' grasp is told to press with (N)."""
WAY, WAY_TIME = math.hypot(0.03, 0.06), 2.5
"""Of the two users' carry (m, s)."""
SHORT_WAY = math.hypot(0.03, 0.03)
"""Of three and four users (m)."""
NETWORK_PERIOD = 1.0 / 128.0
COUNT = 2.0 * math.pi / 20000.0 * 0.1
"""One count of an encoder, at the tip (m)."""


def outer_force() -> float:
    """What acts on a steady grasp from outside (N): no force of a stable one varies by more.

    Friction of the ground and of a finger's joints, inertia of the carry at its largest
    acceleration (minimum jerk), and one encoder count over the stiffest normal coupler.
    """
    inertia = MASS * 10.0 / math.sqrt(3.0) * WAY / WAY_TIME**2
    return GROUND + JOINTS + inertia + LOCAL_NORMAL * COUNT


def carried(copies: int, fingers: int, way: float) -> float:
    """How far the box comes at least (m): the way, less what friction withholds from the hands."""
    return way - (copies * GROUND + fingers * JOINTS) / (fingers * HAND)


def lag(samples: int) -> float:
    """How far copies with the same users can be apart (m), in a grasp by two fingers each.

    At rest the ground holds a copy against K_o and two remote fingers. On the way each sample that
    one direction is later than the other adds what the box moves meanwhile at its largest speed.
    """
    speed = 1.875 * WAY / WAY_TIME
    return GROUND / (BETWEEN + 2.0 * REMOTE_NORMAL) + samples * NETWORK_PERIOD * speed


def pulled_apart(wanted: float) -> float:
    """The same (m) where one user wants the box ``wanted`` (m) lower than the other.

    Two fingers a user stick to the own copy. The other's two slide on it, because K_12 presses
    little; they and K_o hold the copies together, the friction of ground and joints apart.
    """
    normal = SQUEEZE / (1.0 + HAND / LOCAL_NORMAL)
    sliding = 2.0 * STICKS * REMOTE_NORMAL * normal / LOCAL_NORMAL
    hands = 2.0 * HAND * LOCAL_TANGENTIAL / (HAND + LOCAL_TANGENTIAL)
    apart = hands * wanted / 2.0 - sliding + GROUND + 2.0 * JOINTS * hands / (2.0 * HAND)
    return apart / (hands / 2.0 + BETWEEN)


def pressed_apart(users: int, push: float = 2.0) -> float:
    """The same (m) for two users who press on opposite faces with a finger each.

    Each presses with K_11 on the own copy and with K_12 on the other's. K_o of all copies holds
    them together; fingers along the faces would help and are left out, friction holds them apart.
    """
    own = LOCAL_NORMAL / (HAND + LOCAL_NORMAL)
    press = push * own
    held = REMOTE_NORMAL * (press / LOCAL_NORMAL)
    stiffness = HAND * own + REMOTE_NORMAL * (2.0 - HAND / (HAND + LOCAL_NORMAL))
    stiffness += users * BETWEEN
    return 2.0 * (press - held + GROUND + JOINTS) / stiffness
