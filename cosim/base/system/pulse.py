"""The shared memory of a paced run's three processes: command, supervisor and control loop.

Each beats as it goes on, so that the others see progress and not only life. The loop marks a frame
while it is being written, and every device while it may be pushing: ``hot`` is raised before a
torque other than zero is written, and ``confirmed`` follows it once an answer confirms zero. While
they differ, nobody may say that the motors are at rest. An anonymous shared mapping: inherited over
fork, gone with the last process.
"""

from __future__ import annotations

import mmap
import os
from enum import IntEnum

STARTING, RUNNING, FINISHED = range(3)
"""Where the loop is; while it is RUNNING its beats are watched."""
SILENT_TICKS = 200
"""Ticks of the loop without a beat of its supervisor, after which that one counts as stopped."""
MOST_DEVICES = 64
"""Of one run."""


class Who(IntEnum):
    """The processes of a paced run."""

    COMMAND = 0
    SUPERVISOR = 1
    LOOP = 2


_STATE, _LOOP_ID, _SUPERVISOR_ID, _STOP, _DEVICE, _LENGTH, _WRITTEN = range(3, 10)
_HOT, _CONFIRMED = 16, 16 + MOST_DEVICES


class Pulse:
    """Shared integers; made before the first fork, by the process that supervises or forks it."""

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, mmap.PAGESIZE)
        self._cells = memoryview(self._memory).cast("q")
        self._cells[_SUPERVISOR_ID] = os.getpid()
        self.who = Who.LOOP
        """Which of the three this process is."""
        self._heard = (0, 0)
        """The supervisor's newest beat, and the loop's own when it came."""

    # --- everybody's side ---

    def beats(self, who: Who) -> int:
        """How often a process has gone on so far."""
        return self._cells[who]

    def ask_to_stop(self) -> None:
        """Have the loop zero its devices at its next tick, and end."""
        self._cells[_STOP] = 1

    @property
    def stop_asked(self) -> bool:
        """Whether somebody has asked for the end."""
        return bool(self._cells[_STOP])

    def is_cold(self, device: int) -> bool:
        """Whether a zero was confirmed since the last torque that was not zero."""
        return self._cells[_HOT + device] == self._cells[_CONFIRMED + device]

    # --- the side of whoever writes to the devices ---

    def beat(self) -> None:
        """This process goes on; the loop: one more tick was begun."""
        self._cells[self.who] += 1

    def state(self, value: int) -> None:
        """Say where the loop is: STARTING, RUNNING (it is watched), FINISHED."""
        self._cells[_STATE] = value

    def heat(self, device: int) -> None:
        """A torque other than zero is about to be written to a device."""
        self._cells[_HOT + device] += 1

    def cool(self, device: int) -> None:
        """An answer has confirmed zero, and nothing but zero was written since it was asked for."""
        self._cells[_CONFIRMED + device] = self._cells[_HOT + device]

    def begin(self, device: int, length: int) -> None:
        """A frame of ``length`` bytes is about to be written to a device."""
        self._cells[_DEVICE] = device
        self._cells[_WRITTEN] = 0
        self._cells[_LENGTH] = length

    def progress(self, written: int) -> None:
        """So many bytes of it are out."""
        self._cells[_WRITTEN] = written

    def end(self) -> None:
        """The frame is complete."""
        self._cells[_LENGTH] = 0

    def supervisor_alive(self) -> bool:
        """Whether the supervisor is still the loop's parent (or is the loop itself)."""
        return self._cells[_SUPERVISOR_ID] in {os.getppid(), os.getpid()}

    def supervisor_silent(self) -> bool:
        """Whether it lives, but has not gone on for :data:`SILENT_TICKS` of the loop's ticks."""
        theirs, own = self._cells[Who.SUPERVISOR], self._cells[Who.LOOP]
        if theirs != self._heard[0] or own < self._heard[1]:
            self._heard = (theirs, own)
        return own - self._heard[1] > SILENT_TICKS

    # --- the side of whoever watches ---

    def supervised_here(self) -> None:
        """This process is the supervisor."""
        self._cells[_SUPERVISOR_ID] = os.getpid()

    @property
    def supervisor_id(self) -> int:
        """The supervisor's process number."""
        return self._cells[_SUPERVISOR_ID]

    @property
    def loop_id(self) -> int:
        """The loop's process number, 0 before there is one."""
        return self._cells[_LOOP_ID]

    @loop_id.setter
    def loop_id(self, number: int) -> None:
        self._cells[_LOOP_ID] = number

    @property
    def counter(self) -> int:
        """Ticks begun so far."""
        return self._cells[Who.LOOP]

    @property
    def loop_state(self) -> int:
        """What the loop last said."""
        return self._cells[_STATE]

    def torn(self) -> tuple[int, int, int] | None:
        """Device, length and bytes known to be out of a frame being written; ``None`` between."""
        length = self._cells[_LENGTH]
        return (self._cells[_DEVICE], length, self._cells[_WRITTEN]) if length else None
