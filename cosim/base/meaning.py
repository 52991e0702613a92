"""What a variable means to those that look for it, whatever it is called.

A model declares it (``fmus/table.py``, a Python component's ``Variable``), an FMU carries it in an
annotation (docs/fmus.md), a record keeps it with the column. Who is looked for by meaning is never
looked for by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Meaning(StrEnum):
    """Every meaning that something looks for; docs/fmus.md lists who does."""

    PEER_WEIGHT = "peer_weight"
    """Input: scales what a peer says, 0 to 1."""
    PEER_VALID = "peer_valid"
    """Input: whether a peer counts."""
    PEER_AGE = "peer_age"
    """Input: base ticks since what a peer says was measured."""
    PEER_STATE = "peer_state"
    """Input: part of what a peer says, beside the three that tell what the link knows of it."""
    SOURCE_TICK = "source_tick"
    """Output in a packet: tick of its content, -1 where there is none."""
    SOURCE_AGE = "source_age"
    """Output in a packet: base ticks by which its content is older than the packet."""
    SOURCE_STATUS = "source_status"
    """Output in a packet: bits of its sender's state; a peer without bit 2 or with bit 4 fades."""
    BOX_X = "box_x"
    """Output: position of a copy of the box, x (m)."""
    BOX_Y = "box_y"
    """Output: position of a copy of the box, y (m)."""
    BOX_ANGLE = "box_angle"
    """Output: angle of a copy of the box (rad)."""
    WALL_PENETRATION = "wall_penetration"
    """Output: depth of the box in a wall (m)."""
    CONTACT_STATE = "contact_state"
    """Output: a finger on this copy of the box, 0 free, else touching."""
    NORMAL_FORCE = "normal_force"
    """Output: normal force of a finger on this copy of the box (N)."""
    FINGER_X = "finger_x"
    """Output: position of an own finger's tip, x (m)."""
    FINGER_Y = "finger_y"
    """Output: position of an own finger's tip, y (m)."""
    TIP_POSITION = "tip_position"
    """Output: position of a device's tip (m)."""
    MOTOR_TORQUE = "motor_torque"
    """Input: torque that a device's motor is to give (N.m)."""
    AXIS_POSITION = "axis_position"
    """Output: position of a body on one axis (m)."""
    AXIS_VELOCITY = "axis_velocity"
    """Output: velocity of a body on one axis (m/s)."""
    AXIS_FORCE = "axis_force"
    """A force on one axis (N): a user's on the body, a virtual coupler's."""
    SAMPLE_PERIOD = "sample_period"
    """Parameter: the component's own period (s); follows from its rate."""
    NETWORK_TICKS = "network_ticks"
    """Parameter: own periods in a network period; follows from the rates."""
    FILE = "file"
    """Text parameter: the name of a file, relative to the file that it is written in."""
    OWN_DEVICE = "own_device"
    """Parameter: describes a station's own device and where it stands; no affair of a peer's."""


@dataclass(frozen=True, slots=True)
class Slot:
    """Which of several a variable belongs to; numbers count from 1, ``None`` where there is one."""

    peer: int | None = None
    finger: int | None = None


NO_SLOT = Slot()
