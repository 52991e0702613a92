"""FAULT: entered on any error, answered with zeros until it is known what became of the motors."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

from hil.device.contract import CUT_POWER, ZERO, Cause, Flag, Outcome, Sent, State
from hil.device.driver import Driver
from hil.device.errors import DeviceError, DeviceFault, LifecycleError
from hil.safety.layer import Trip
from hil.safety.linkage import Pair

SETTLE_TICKS = 24
"""Ticks after a fault within which a zero has to be confirmed."""


class FaultLatch(Driver):
    """A device's state, and the one way into FAULT; there is none out of it but ``reset``."""

    state: State = State.UNCONFIGURED
    homed: bool = False
    fault: Trip | None = None
    outcome: Outcome | None = None
    outcome_ticks: int = 0
    _zeros_before: int = 0

    @property
    @final
    def settled(self) -> bool:
        """Whether it is known what became of the motors after a fault."""
        return self.outcome is not None and self.outcome is not Outcome.PENDING

    @final
    def fault_sentence(self) -> str:
        """Why the device is in FAULT and what is known of its output."""
        if self.fault is None:
            return f"{self.name} is not in FAULT"
        known = {
            Outcome.ZERO_CONFIRMED: f"zero torque confirmed after {self.outcome_ticks} ticks",
            Outcome.WATCHDOG: "no answer; its own watchdog drops the torque "
            f"within {(self.watchdog.timeout or 0.0) * 1e3:.0f} ms",
            Outcome.UNKNOWN: f"output unknown, {CUT_POWER}",
        }.get(self.outcome or Outcome.PENDING, "its output is not known yet")
        return f"{self.name} is in FAULT ({self.fault.cause}): {self.fault.sentence}; {known}"

    @final
    def raise_fault(self) -> None:
        """End the run where the device is in FAULT and its outcome is known.

        Raises:
            DeviceFault: always, then.
        """
        if self.state is State.FAULT and self.settled:
            raise DeviceFault(self.fault_sentence())

    @final
    def _expect(self, call: str, *states: State) -> None:
        if self.state not in states:
            wanted = " or ".join(state.value for state in states)
            raise LifecycleError(
                f"{call}: {self.name} is {self.state.value}, it would have to be {wanted}"
            )

    @final
    def _trip_on(self, error: Exception) -> None:
        cause = error.cause if isinstance(error, DeviceError) else Cause.PORT
        self._trip(Trip(cause, str(error) or type(error).__name__))

    @final
    def _trip(self, trip: Trip) -> None:
        if self.state is State.FAULT:
            return
        self.state, self.fault, self.outcome = State.FAULT, trip, Outcome.PENDING
        self.outcome_ticks, self._zeros_before = 0, self.zeros_confirmed
        if trip.cause.unhomes:
            self.homed = False

    @final
    def _write_zero(self, limited: Pair, flags: Flag) -> Sent:
        sent = self._zero()
        if self.state is State.FAULT and not self.settled:
            self._settle()
            self.outcome_ticks += 0 if self.settled else 1
        return Sent(torque=ZERO, limited=limited, flags=flags if sent else flags | Flag.NOT_SENT)

    @final
    def _settle(self) -> None:
        assert self.fault is not None
        confirmed = self.zeros_confirmed > self._zeros_before
        # A device that moved as no command explains is not believed when it says it is at zero.
        if confirmed and (self.in_process or not self.fault.cause.is_motion):
            self.outcome = Outcome.ZERO_CONFIRMED
        elif self.outcome_ticks >= SETTLE_TICKS:
            trusted = self.watchdog.verified and not self.fault.cause.is_motion
            self.outcome = Outcome.WATCHDOG if trusted else Outcome.UNKNOWN

    @final
    def _zero(self) -> bool:
        return self._guard(self._send_zero)

    @final
    def _guard(self, call: Callable[[], object]) -> bool:
        """Run a hook on a path that must go on; whether it worked."""
        try:
            call()
        except Exception as error:
            if self.state in {State.ACTIVE, State.INACTIVE}:
                self._trip_on(error)
            return False
        return True
