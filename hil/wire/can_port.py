"""What a CAN bus sends and receives frames through: a socket of the kernel's, or python-can."""

from __future__ import annotations

from contextlib import AbstractContextManager
from enum import Enum
from typing import Any, NamedTuple, Protocol


class FrameKind(Enum):
    """What came."""

    DATA = "data"
    ERROR = "error"
    """The controller's own word; the identifier is its class."""
    SENT = "sent"
    """One of ours that really was on the bus."""
    OTHER = "other"
    """Remote and extended frames, which nobody here sends."""


class CanFrame(NamedTuple):
    """One frame."""

    identifier: int
    data: bytes
    kind: FrameKind = FrameKind.DATA


class CanPort(Protocol):
    """An open port; every call raises ``DeviceGone`` where the bus is gone."""

    @property
    def tells_sent(self) -> bool:
        """Whether every frame of ours comes back as ``SENT`` once it was on the bus."""
        ...

    def send(self, identifier: int, data: bytes, *, remote: bool) -> None:
        """Queue a frame."""
        ...

    def receive(self, wait: float) -> CanFrame | None:
        """The next frame, ``None`` where none comes within ``wait`` (s)."""
        ...

    def for_set_up(self) -> AbstractContextManager[Any]:
        """A python-can bus on the same wire, for a package that wants one."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...
