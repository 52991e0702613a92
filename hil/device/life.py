"""Where a device is in its life, and how it falls into FAULT: latched, and told to its siblings."""

from __future__ import annotations

from collections.abc import Callable

from hil.device.contract import State
from hil.device.driver import Driver
from hil.device.errors import Cause, DeviceError, LifecycleError
from hil.device.fault_latch import FaultLatch
from hil.safety.layer import Trip


class Alarm:
    """What the devices of one run share: raised by each that goes into FAULT, until it is reset.

    A fault that is found while reading brings the others to zero in the same tick, because all
    devices read before any writes; one that is found while writing does so at the next.
    """

    def __init__(self) -> None:
        self._raised: list[str] = []

    @property
    def raised_by(self) -> str | None:
        """The first device that is still in FAULT."""
        return self._raised[0] if self._raised else None

    def raise_for(self, name: str) -> None:
        """A device is in FAULT."""
        self._raised.append(name)

    def withdraw(self, name: str) -> None:
        """It was reset."""
        self._raised.remove(name)


class Life:
    """The state of one device; calls that do not fit it are refused, and errors end in FAULT."""

    def __init__(self, driver: Driver, alarm: Alarm) -> None:
        self.driver, self.alarm = driver, alarm
        self.state = State.UNCONFIGURED
        self.homed = False
        self.latch = FaultLatch()

    def expect(self, call: str, *states: State) -> None:
        """Refuse a call in any other state.

        Raises:
            LifecycleError: it is in another one.
        """
        if self.state not in states:
            wanted = " or ".join(state.value for state in states)
            raise LifecycleError(
                f"{call}: {self.driver.name} is {self.state.value}, it would have to be {wanted}"
            )

    def trip(self, trip: Trip) -> None:
        """Into FAULT; the first reason is kept."""
        if self.state in {State.ACTIVE, State.INACTIVE} and self.latch.set(trip):
            self.state = State.FAULT
            self.alarm.raise_for(self.driver.name)
            if trip.cause.unhomes:
                self.homed = False

    def trip_on(self, error: Exception) -> None:
        """Into FAULT, whatever failed."""
        cause = error.cause if isinstance(error, DeviceError) else Cause.PORT
        self.trip(Trip(cause, str(error) or type(error).__name__))

    def guard(self, call: Callable[[], object]) -> bool:
        """Run a call on a path that must go on; whether it worked."""
        try:
            call()
        except Exception as error:
            self.trip_on(error)
            return False
        return True

    def end(self) -> None:
        """The port is closed; what was in FAULT says why until it is opened again."""
        self.state, self.homed = State.UNCONFIGURED, False

    def clear_fault(self) -> None:
        """What was in FAULT, and was reset or closed, is none of its siblings' business now."""
        if self.latch.fault is not None:
            self.latch.clear()
            self.alarm.withdraw(self.driver.name)
