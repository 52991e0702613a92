"""What has to be well around a device at every tick for its command to be followed."""

from __future__ import annotations

from collections.abc import Callable

from cosim.base.system.pulse import Pulse
from cosim.base.system.sleep import SleepWatch
from hil.device.errors import Cause
from hil.device.life import Alarm
from hil.safety.layer import Trip
from hil.safety.limits import LATE_SECONDS
from hil.safety.permission import Permission


class Conditions:
    """Supervisor, clock, sleep, the run's other devices, and the dead-man input.

    ``clock`` gives host seconds for the rules that need one; ``None`` (lock-step) means that
    nothing goes by a clock. ``tick`` is the control period (s).
    """

    def __init__(
        self, pulse: Pulse | None, clock: Callable[[], float] | None, alarm: Alarm, tick: float
    ) -> None:
        self.pulse, self.clock, self.alarm, self.tick = pulse, clock, alarm, tick
        self.sleep = SleepWatch()
        self._written: float | None = None
        """Host time (s) of the last write while ACTIVE."""

    def start(self) -> None:
        """The device was activated: lateness counts from the next write."""
        self._written = None

    def reason_to_stop(self, permission: Permission | None) -> Trip | None:
        """Why this tick's command must not be followed, whatever it is."""
        pulse = self.pulse
        if pulse is not None and not pulse.supervisor_alive():
            return Trip(Cause.SUPERVISOR, "the supervisor process died")
        trip = None if self.clock is None else self._by_the_clock(self.clock)
        if trip is not None:
            return trip
        if self.alarm.raised_by is not None:
            return Trip(Cause.SIBLING, f"{self.alarm.raised_by} is in FAULT")
        held = None if permission is None else permission.is_held
        if held is not None and not held():
            return Trip(Cause.DEAD_MAN, "the dead-man input was released")
        return None

    def _by_the_clock(self, clock: Callable[[], float]) -> Trip | None:
        if self.pulse is not None and self.pulse.supervisor_silent():
            return Trip(Cause.SUPERVISOR, "the supervisor process stands still")
        slept = self.sleep.slept()
        if slept:
            return Trip(Cause.SLEPT, f"this machine was asleep for {slept:.1f} s")
        now = clock()
        late = 0.0 if self._written is None else now - self._written - self.tick
        self._written = now
        if late > LATE_SECONDS:
            return Trip(Cause.LATE, f"the control loop came {late * 1e3:.1f} ms late")
        return None
