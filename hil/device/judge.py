"""What a device makes of what its board says of itself: every reply is judged."""

from __future__ import annotations

import time

from hil.device.contract import Received, State
from hil.device.errors import BoardError, Cause
from hil.safety.layer import Trip

LONGEST_STEP = 1.0
"""A board's clock that goes on by so much more than the host's (s) between two samples was set
anew."""
SETTLING_REPLIES = 8
"""Replies in which a board's account of its output may still be that of an earlier command."""
FROZEN_REPLIES = 8
"""Replies in a row that may have one and the same time: some clocks are coarse."""


class Judge:
    """Judges one device's replies; it keeps the little that takes two of them to see."""

    def __init__(self) -> None:
        self._time: float | None = None
        self._host = 0.0
        self._frozen = 0
        self.commanded_anew()

    def forget(self) -> None:
        """The port was opened: the board's clock may stand anywhere."""
        self._time, self._frozen = None, 0
        self.commanded_anew()

    def commanded_anew(self) -> None:
        """The device was activated, or no longer is: its board has to follow."""
        self._astray, self._followed, self._contradicted = 0, False, 0

    def verdict(self, received: Received, state: State) -> Trip | None:
        """Why the device has to go into FAULT because of what came in a tick, or ``None``."""
        trips = (self._of_one(each, state) for each in received.each)
        return next((trip for trip in trips if trip is not None), None)

    def _of_one(self, received: Received, state: State) -> Trip | None:
        error = received.error
        if error is not None:
            return Trip(error.cause, str(error))
        return (
            self._clock(received)
            or self._watchdog(received, state)
            or self._output_stage(received, state)
            or self._account(received)
        )

    def _clock(self, received: Received) -> Trip | None:
        now, before = received.device_time, self._time
        if now is None:
            return None
        passed, self._host = time.monotonic() - self._host, time.monotonic()
        self._time = now
        if before is None or 0.0 < now - before < LONGEST_STEP + passed:
            self._frozen = 0
            return None
        if now == before:
            return self._standing(now)
        way = "ran back" if now < before else "leapt"
        return Trip(
            Cause.RESTARTED,
            f"the board's own clock {way} from {before:.4f} s to {now:.4f} s: it has started anew",
        )

    def _standing(self, now: float) -> Trip | None:
        self._frozen += 1
        if self._frozen < FROZEN_REPLIES:
            return None
        return Trip(
            BoardError.cause,
            f"the board's own clock stands still at {now:.4f} s: it repeats itself",
        )

    def _watchdog(self, received: Received, state: State) -> Trip | None:
        """While nothing was commanded on, one that fired is cleared by the next activation."""
        if received.watchdog_fired and state is State.ACTIVE:
            return Trip(BoardError.cause, "the board reports that its watchdog has fired")
        return None

    def _output_stage(self, received: Received, state: State) -> Trip | None:
        wanted = state is State.ACTIVE
        if received.enabled is None:
            return None
        if received.enabled is wanted:
            self._followed, self._astray = wanted, 0
            return None
        self._astray += 1
        if not (self._followed or self._astray > SETTLING_REPLIES):
            return None
        is_, was = ("off", "on") if wanted else ("on", "off")
        return Trip(
            BoardError.cause,
            f"the board says that its output stage is {is_}, though it was commanded {was}",
        )

    def _account(self, received: Received) -> Trip | None:
        """One reply may be about an earlier command, many in a row are not."""
        if received.contradiction is None:
            return None
        self._contradicted = self._contradicted + 1 if received.contradiction else 0
        if self._contradicted <= SETTLING_REPLIES:
            return None
        return Trip(BoardError.cause, received.contradiction)
