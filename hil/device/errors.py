"""What can go wrong with a device; every one ends a run with exit status 1 and a sentence."""

from __future__ import annotations

from typing import ClassVar

from cosim.base.errors import RunError
from hil.device.contract import Cause


class DeviceError(RunError):
    """A device could not do what it was asked; ``cause`` is what its fault is then called."""

    cause: ClassVar[Cause] = Cause.PORT


class LifecycleError(DeviceError):
    """A call came in a state that does not allow it (a programming mistake, not a hazard)."""


class ActivationRefused(DeviceError):
    """The device must not produce force now: not homed, moving, outside its workspace, ..."""


class DeviceGone(DeviceError):
    """The port failed: unplugged, closed, or the other end no longer takes bytes."""


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
