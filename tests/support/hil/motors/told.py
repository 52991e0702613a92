"""What a pair of motors makes of some bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Told:
    """One thing that happened: what they were told, and what they say to it."""

    torques: tuple[float, ...] | None = None
    """N.m, where a torque came."""
    answer: bytes = b""
    zero: bool = False
    """Whether the answer says that they are at zero."""


class Motors(Protocol):
    """Two motors behind one protocol."""

    def feed(self, data: bytes) -> list[Told]:
        """Bytes came."""
        ...

    def tick(self) -> list[Told]:
        """About a millisecond has passed."""
        ...
