"""Faults that an emulator can be told to have, counted in ticks."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class FaultKind(StrEnum):
    """What goes wrong."""

    DROP = "drop"
    """Answers are lost."""
    DROP_COMMAND = "drop-command"
    """One byte (one frame on CAN) from the host is lost."""
    CORRUPT = "corrupt"
    """A bit of every answer is flipped."""
    CORRUPT_COMMAND = "corrupt-command"
    """A bit of what the host sends is flipped."""
    DELAY = "delay"
    """Answers come so many ticks late."""
    HANG = "hang"
    """The board's program stands still; its hardware keeps doing what it did."""
    UNPLUG = "unplug"
    """The cable is pulled; the motors keep their supply."""
    RUNAWAY = "runaway"
    """The motors push with all they have, whatever is commanded."""
    LATCHED = "latched"
    """The motors keep their last torque, whatever is commanded."""
    RESTART = "restart"
    """The board starts anew, as after a dip of its supply."""
    BROWN_OUT = "brown-out"
    """The supply of a sensor's bridges dips; the board itself goes on (force_sensor)."""
    SATURATE = "saturate"
    """A channel of a sensor stands at the end of its range (force_sensor)."""
    ALARM = "alarm"
    """The board reports an error of its own (CANopen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One fault: from tick ``start`` (counted from when it is told) for ``ticks`` ticks."""

    kind: FaultKind
    start: int = 0
    ticks: int = 1_000_000_000
    delay: int = 1
    """For DELAY: how many ticks."""
    bit: int = 0
    """For CORRUPT: which bit of the answer, counted from its first byte."""

    def active(self, tick: int) -> bool:
        """Whether it is there at a tick."""
        return self.start <= tick < self.start + self.ticks
