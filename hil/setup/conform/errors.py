"""How a rule of the conformance suite ends where it is not kept."""

from __future__ import annotations

from hil.device.errors import DeviceError


class NotConform(DeviceError):
    """The board, or its driver, breaks the rule; the sentence says how it was seen."""


class NotTried(DeviceError):
    """The rule says nothing about this board, or cannot be tried here; the sentence says why."""
