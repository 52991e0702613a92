"""What every emulated board has: something comes in, something goes out, time passes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from hil.emulation.world import World


@dataclass(frozen=True, slots=True)
class BoardFrame:
    """A classic CAN frame with an 11-bit identifier."""

    identifier: int
    data: bytes = b""
    remote: bool = False


Unit = bytes | BoardFrame
"""What a link carries: bytes on a serial line, frames on a bus."""


class Board(ABC):
    """The firmware of a device: it holds the torque, and answers in its own protocol."""

    def __init__(self, world: World) -> None:
        self.world = world

    @abstractmethod
    def receive(self, unit: Unit) -> list[Unit]:
        """Take what came, and answer. Calls ``world.boundary()`` where its tick ends."""

    def tick(self) -> list[Unit]:
        """One control tick of the board's own time has passed: watchdogs, cyclic messages."""
        return []
