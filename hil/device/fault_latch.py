"""FAULT: entered on any error, and left by ``reset`` alone; and what became of the motors."""

from __future__ import annotations

from hil.device.contract import CUT_POWER, Watchdog, WriteOutcome
from hil.safety.layer import Trip

SETTLE_TICKS = 24
"""Ticks after a fault within which a zero has to be confirmed."""


class FaultLatch:
    """The first fault of a device, and its outcome once that is known."""

    def __init__(self) -> None:
        self.fault: Trip | None = None
        self.outcome: WriteOutcome | None = None
        self.ticks = 0
        """Writes from the fault to its outcome."""
        self._confirmed = False

    @property
    def settled(self) -> bool:
        """Whether it is known what became of the motors."""
        return self.outcome is not None and self.outcome is not WriteOutcome.PENDING

    def set(self, trip: Trip) -> bool:
        """Latch a fault; whether it was the first one."""
        if self.fault is not None:
            return False
        self.fault, self.outcome, self.ticks, self._confirmed = trip, WriteOutcome.PENDING, 0, False
        return True

    def confirm(self) -> None:
        """An answer has confirmed zero torque."""
        self._confirmed = True

    def settle(self, watchdog: Watchdog, *, in_process: bool) -> None:
        """One more zero was sent: is it known by now what became of the motors?

        A device that moved as no command explains is not believed when it says it is at zero.
        """
        if self.fault is None or self.settled:
            return
        moved = self.fault.cause.is_motion
        if self._confirmed and (in_process or not moved):
            self.outcome = WriteOutcome.ZERO_CONFIRMED
        elif self.ticks >= SETTLE_TICKS:
            trusted = watchdog.protects and not moved
            self.outcome = WriteOutcome.WATCHDOG if trusted else WriteOutcome.UNKNOWN
        else:
            self.ticks += 1

    def sentence(self, name: str, watchdog: Watchdog) -> str:
        """Why the device ``name`` is in FAULT and what is known of its output."""
        if self.fault is None:
            return f"{name} is not in FAULT"
        known = {
            WriteOutcome.ZERO_CONFIRMED: f"zero torque confirmed after {self.ticks} ticks",
            WriteOutcome.WATCHDOG: "no answer; its own watchdog drops the torque "
            f"within {(watchdog.timeout or 0.0) * 1e3:.0f} ms",
            WriteOutcome.UNKNOWN: f"output unknown, {CUT_POWER}",
        }.get(self.outcome or WriteOutcome.PENDING, "its output is not known yet")
        return f"{name} is in FAULT ({self.fault.cause}): {self.fault.sentence}; {known}"

    def clear(self) -> None:
        """Leave FAULT."""
        self.fault = self.outcome = None
