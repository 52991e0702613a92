"""Who moves a handle when that has to be seen: a person who is asked, or an emulator's hand."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import closing
from math import pi

from hil.wire.side_channel import Control

EMULATED_TURN = 0.25
"""How far an emulator's hand turns a joint (rad)."""


class Turner(ABC):
    """Moves one joint (0 or 1) of a handle at a time."""

    angle: float
    """By how much it turns one (rad)."""

    @abstractmethod
    def leave(self, joint: int) -> None:
        """Return once the joint rests where it was first."""

    @abstractmethod
    def turn(self, joint: int) -> None:
        """Return once the joint was turned counterclockwise, as seen from above."""

    def let_go(self) -> None:
        """The joints may go back."""


class AskedTurner(Turner):
    """``ask`` shows a sentence and returns once it was done."""

    angle = pi / 4

    def __init__(self, ask: Callable[[str], object]) -> None:
        self._ask = ask

    def leave(self, joint: int) -> None:
        """Asked for."""
        self._ask(f"Leave joint {joint + 1} where it is and press Enter: ")

    def turn(self, joint: int) -> None:
        """Asked for."""
        self._ask(
            f"Turn joint {joint + 1} counterclockwise by half a right angle, hold it there, "
            "and press Enter: "
        )


class EmulatedTurner(Turner):
    """The hand of the emulator at the other end of the side channel at ``path``."""

    angle = EMULATED_TURN

    def __init__(self, path: str) -> None:
        self._path = path

    def leave(self, joint: int) -> None:
        """Both joints, at once."""
        self._shift(0.0, 0.0)

    def turn(self, joint: int) -> None:
        """By a fixed angle, at once."""
        self._shift(*((EMULATED_TURN, 0.0) if joint == 0 else (0.0, EMULATED_TURN)))

    def let_go(self) -> None:
        """Both joints are back."""
        self._shift(0.0, 0.0)

    def _shift(self, *by: float) -> None:
        with closing(Control(self._path)) as control:
            control.ask("shift", by=by)
