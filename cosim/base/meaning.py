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
    TOLD_X = "told_x"
    """Output in a packet: where an own finger is said to be, x (m)."""
    TOLD_Y = "told_y"
    """Output in a packet: where an own finger is said to be, y (m)."""
    TOLD_VELOCITY_X = "told_velocity_x"
    """Output in a packet: how fast an own finger is said to move, x (m/s)."""
    TOLD_VELOCITY_Y = "told_velocity_y"
    """Output in a packet: how fast an own finger is said to move, y (m/s)."""
    PREDICTOR = "predictor"
    """Parameter: where a peer is taken to be between its packets."""
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
    SATURATION = "saturation"
    """Output: ticks in which an own finger was to be given more than its device can."""
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
    DEVICE_PRESET = "device_preset"
    """Parameter of an own device: whose values stand for those that are left at -1."""
    PROXIMAL_LENGTH = "proximal_length"
    """Parameter of an own device: length of the links at the motors (m)."""
    BASE_DISTANCE = "base_distance"
    """Parameter of an own device: distance between its motors (m)."""
    BASE_X = "base_x"
    """Parameter of an own device: its place in the world, the axis of motor 1, x (m)."""
    BASE_Y = "base_y"
    """Parameter of an own device: its place in the world, the axis of motor 1, y (m)."""
    BASE_ANGLE = "base_angle"
    """Parameter of an own device: angle of its x axis, motor 1 to motor 2, in the world (rad)."""
    JOINT_ANGLE_1 = "joint_angle_1"
    """Input: measured angle of an own device's link at motor 1 (rad)."""
    JOINT_ANGLE_2 = "joint_angle_2"
    """Input: measured angle of an own device's link at motor 2 (rad)."""
    FINGER_FORCE_X = "finger_force_x"
    """Output: force that an own finger is given, x (N)."""
    FINGER_FORCE_Y = "finger_force_y"
    """Output: force that an own finger is given, y (N)."""
    PORT_ENERGY = "port_energy"
    """Output: energy that a user has put into what is rendered (J)."""
    FORCE_LIMIT = "force_limit"
    """Parameter of an own device: largest force on its finger (N)."""
    NODE_POSITION = "node_position"
    """Output: x and y of points of the object, 3 x 3, row by row from its lower left (m)."""
    BOX_SIDE = "box_side"
    """Parameter: side of the square box (m)."""
    STATIC_FRICTION = "static_friction"
    """Parameter: coefficient of static friction of fingers on the box."""
    POINTER_X = "pointer_x"
    """Output: where a person wants a finger, x (m)."""
    POINTER_Y = "pointer_y"
    """Output: where a person wants a finger, y (m)."""
    POINTER_VALID = "pointer_valid"
    """Output: whether a person is there."""
    POINTER_COUNT = "pointer_count"
    """Output: number of the sample of a person's pointer."""
    POINTER_AGE = "pointer_age"
    """Output: time since that sample was taken (s)."""
    REACH_X = "reach_x"
    """Parameter: middle of where a finger may be led, x (m)."""
    REACH_Y = "reach_y"
    """Parameter: middle of where a finger may be led, y (m)."""
    REACH = "reach"
    """Parameter: how far from that middle a finger may be led (m)."""
    FADED_FIRST = "faded_first"
    """Input of a crossfade: what the first of two worlds asks for."""
    FADED_SECOND = "faded_second"
    """Input of a crossfade: what the second asks for."""
    FADED_SHARE = "faded_share"
    """Output of a crossfade: share of the second world, 0 to 1."""
    WALL_ENABLED = "wall_enabled"
    """Parameter: whether there is the wall that its group describes."""
    WALL_POINT_X = "wall_point_x"
    """Parameter: a point on the wall, x (m)."""
    WALL_POINT_Y = "wall_point_y"
    """Parameter: a point on the wall, y (m)."""
    WALL_NORMAL_X = "wall_normal_x"
    """Parameter: normal of the wall into the free half-plane, x."""
    WALL_NORMAL_Y = "wall_normal_y"
    """Parameter: normal of the wall into the free half-plane, y."""


OF_OWN_DEVICE = frozenset(
    {
        Meaning.OWN_DEVICE,
        Meaning.DEVICE_PRESET,
        Meaning.PROXIMAL_LENGTH,
        Meaning.BASE_DISTANCE,
        Meaning.BASE_X,
        Meaning.BASE_Y,
        Meaning.BASE_ANGLE,
        Meaning.FORCE_LIMIT,
    }
)
"""What describes a station's own device: two stations may differ in it."""


@dataclass(frozen=True, slots=True)
class Slot:
    """Which of several a variable belongs to; numbers count from 1, ``None`` where there is one."""

    peer: int | None = None
    finger: int | None = None


NO_SLOT = Slot()
