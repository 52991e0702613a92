"""What a device makes of what its board says of itself: every reply is judged."""

from __future__ import annotations

import time

from hil.device.contract import Received, State
from hil.device.errors import BoardError, Cause
from hil.safety.layer import Trip

LONGEST_STEP = 1.0
"""A board's clock that goes on by so much more than the host's (s) between two samples was set
anew."""
DISABLED_TICKS = 8
"""Ticks in which an active board may still answer that its output stage is off: answers from
before it was switched on."""


class Judge:
    """Judges one device's replies; it keeps the little that takes two of them to see."""

    def __init__(self) -> None:
        self._time: float | None = None
        self._host = 0.0
        self._disabled = 0
        self._was_enabled = False

    def forget(self) -> None:
        """The port was opened: the board's clock may stand anywhere."""
        self._time = None

    def start(self) -> None:
        """The device was activated: from now on its output stage has to be on."""
        self._disabled, self._was_enabled = 0, False

    def verdict(self, received: Received, state: State) -> Trip | None:
        """Why the device has to go into FAULT because of this reply, or ``None``."""
        error = received.error
        if error is not None:
            return Trip(error.cause, str(error))
        return self._clock(received) or (self._active(received) if state is State.ACTIVE else None)

    def _clock(self, received: Received) -> Trip | None:
        now, before = received.device_time, self._time
        if now is None:
            return None
        passed, self._host = time.monotonic() - self._host, time.monotonic()
        self._time = now
        if before is None or 0.0 <= now - before < LONGEST_STEP + passed:
            return None
        way = "ran back" if now < before else "leapt"
        return Trip(
            Cause.RESTARTED,
            f"the board's own clock {way} from {before:.4f} s to {now:.4f} s: it has started anew",
        )

    def _active(self, received: Received) -> Trip | None:
        if received.watchdog_fired:
            return Trip(BoardError.cause, "the board reports that its watchdog has fired")
        if received.enabled is None:
            return None
        if received.enabled:
            self._was_enabled, self._disabled = True, 0
            return None
        self._disabled += 1
        if self._was_enabled or self._disabled > DISABLED_TICKS:
            return Trip(
                BoardError.cause,
                "the board says that its output stage is off, though it was commanded on",
            )
        return None
