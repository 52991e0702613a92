"""What can go wrong with a device; every one ends a run with exit status 1 and a sentence."""

from __future__ import annotations

from enum import StrEnum
from typing import ClassVar

from cosim.base.errors import RunError


class Cause(StrEnum):
    """Why a device went into FAULT."""

    COMMAND = "command"
    MEASUREMENT = "measurement"
    STALE = "stale"
    JUMP = "jump"
    SPEED = "speed"
    LATE = "late"
    PORT = "port"
    PROTOCOL = "protocol"
    BOARD = "board"
    RESTARTED = "restarted"
    FIRST_COMMAND = "first command"
    SUPERVISOR = "supervisor"
    SIBLING = "another device"
    DEAD_MAN = "dead man"
    SLEPT = "slept"

    @property
    def unhomes(self) -> bool:
        """Whether the joint angles can no longer be trusted afterwards."""
        return self in {
            Cause.MEASUREMENT,
            Cause.JUMP,
            Cause.PORT,
            Cause.PROTOCOL,
            Cause.RESTARTED,
            Cause.STALE,
            Cause.SLEPT,
        }

    @property
    def is_motion(self) -> bool:
        """Whether the device moved in a way that its commands do not explain."""
        return self in {Cause.JUMP, Cause.SPEED}


class DeviceError(RunError):
    """A device could not do what it was asked; ``cause`` is what its fault is then called."""

    cause: ClassVar[Cause] = Cause.PORT


class LifecycleError(DeviceError):
    """A call came in a state that does not allow it (a programming mistake, not a hazard)."""


class ActivationRefused(DeviceError):
    """The device must not produce force now: not homed, moving, outside its workspace, ..."""


class DeviceGone(DeviceError):
    """The port failed: unplugged, closed, or the other end no longer takes bytes."""


class HalfSent(DeviceGone):
    """The bus took some joints' torques and then no more; ``torque`` (N.m) has those by joint."""

    def __init__(self, said: str, torque: dict[int, float]) -> None:
        super().__init__(said)
        self.torque = torque


class NodeLost(DeviceGone):
    """A node on a bus fell silent, started anew, or left the state that it was put into."""


class ProtocolError(DeviceError):
    """Bytes arrived that cannot be a valid answer and that the protocol cannot resynchronise."""

    cause: ClassVar[Cause] = Cause.PROTOCOL


class BoardError(DeviceError):
    """The device itself reports an error."""

    cause: ClassVar[Cause] = Cause.BOARD


class DeviceFault(DeviceError):
    """The device is in FAULT; the sentence says why, and what is known of its output."""
