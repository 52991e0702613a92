"""The shared memory between the control loop and its supervisor.

The loop bumps a counter every tick and marks a frame while it is being written; the supervisor
reads both. An anonymous shared mapping: inherited over fork, gone with the last of the two.
"""

from __future__ import annotations

import mmap
import os

_COUNTER, _STATE, _LENGTH, _WRITTEN, _DEVICE = range(5)
STARTING, RUNNING, FINISHED = range(3)


class Pulse:
    """Five shared integers; made before the fork."""

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, mmap.PAGESIZE)
        self._cells = memoryview(self._memory).cast("q")
        self._supervisor = os.getpid()

    # --- the loop's side ---

    def beat(self) -> None:
        """One more tick was begun."""
        self._cells[_COUNTER] += 1

    def state(self, value: int) -> None:
        """Say where the loop is: STARTING, RUNNING (it is watched), FINISHED."""
        self._cells[_STATE] = value

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
        """Whether the process that made this is still the loop's parent (or is the loop itself)."""
        return self._supervisor in {os.getppid(), os.getpid()}

    # --- the supervisor's side ---

    @property
    def counter(self) -> int:
        """Ticks begun so far."""
        return self._cells[_COUNTER]

    @property
    def loop_state(self) -> int:
        """What the loop last said."""
        return self._cells[_STATE]

    def torn(self) -> tuple[int, int, int] | None:
        """Device, length and bytes known to be out of a frame being written; ``None`` between."""
        length = self._cells[_LENGTH]
        return (self._cells[_DEVICE], length, self._cells[_WRITTEN]) if length else None
