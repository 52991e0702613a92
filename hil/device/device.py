"""A device: two calls a tick, and the only way to its motors.

What stands in one file each: the driver's hooks (``hil.device.driver``), FAULT
(``hil.device.fault_latch``), the heir of a dead loop (``hil.realtime.after_death``), samples
(``hil.device.measuring``), the lifecycle (``hil.device.lifecycle``), the watchdog's proof
(``hil.setup.watchdog_proof``); here the exchange of every tick, which nothing goes around.
"""

from __future__ import annotations

from typing import Any, final

from hil.device.contract import (
    CUT_POWER,
    ZERO,
    Cause,
    Flag,
    Measurement,
    Sent,
    State,
    Status,
)
from hil.safety.layer import Trip
from hil.safety.limits import DROP_TICKS, LATE_SECONDS
from hil.safety.linkage import Pair
from hil.setup.watchdog_proof import WatchdogProving


class Device(WatchdogProving):
    """Base of every driver: derive from it, fill in the hooks of ``hil.device.driver.Driver``."""

    stop_requested: bool = False
    sent: Pair = ZERO
    """The torque of the last write (N.m), for whoever watches."""
    sent_flags: Flag = Flag.NONE
    _reads: int = 0

    @classmethod
    @final
    def component(cls, url: str, options: dict[str, Any], safety: dict[str, Any]) -> Any:
        """The component that a scenario's ``device: URL`` stands for (entry point contract).

        ``safety`` are limits that the scenario puts on every device: the tighter ones hold.
        """
        from hil.device.component import DeviceComponent  # it needs Device itself

        return DeviceComponent(cls, url, options, safety)

    @final
    def read(self, tick: int) -> Measurement:
        """This tick's measurement, or the last one with its age. Never raises on the wire."""
        self._expect("read", State.INACTIVE, State.ACTIVE, State.FAULT)
        self._reads += 1
        fresh = self._take()
        self._age = 0 if fresh else self._age + 1
        angle = self._joint_angle()
        if self.state is not State.FAULT and (self._sample is not None or self._age >= DROP_TICKS):
            known = angle if self._sample is not None else ZERO
            trip = self.safety.observe(self._reads, known, self._age, homed=self.homed)
            if trip is not None:
                self._trip(trip)
        sample = self._sample
        return Measurement(
            joint_angle=angle,
            count=sample.count if sample else (0, 0),
            sequence=sample.sequence if sample else -1,
            sample_age=self._age,
            status=self.status,
            device_time=sample.device_time if sample else None,
            host_time=self._clock() if self._clock else tick * self.tick,
        )

    @final
    def write(self, tick: int, command: Pair) -> Sent:
        """Send what the safety layer leaves of a torque command (N.m). Never raises on the wire."""
        sent = self._write_limited(tick, command)
        self.sent, self.sent_flags = sent.torque, sent.flags
        return sent

    @final
    def _write_limited(self, tick: int, command: Pair) -> Sent:
        self._expect("write", State.INACTIVE, State.ACTIVE, State.FAULT)
        if self.state is State.ACTIVE:
            self._check_time()
        if self.state is not State.ACTIVE:
            return self._write_zero(ZERO, Flag.NONE)
        if self.stop_requested:
            self._trip(Trip(Cause.STOPPED, "the run was asked to stop"))
            return self._write_zero(ZERO, Flag.NONE)
        if self._is_let_go():
            self._trip(Trip(Cause.DEAD_MAN, "the dead-man input was released"))
            return self._write_zero(ZERO, Flag.NONE)
        decision = self.safety.limit(tick, command)
        if decision.trip is not None:
            self._trip(decision.trip)
            return self._write_zero(ZERO, decision.flags)
        allowed = decision.torque if self.permission is not None else ZERO
        flags = decision.flags if self.permission is not None else decision.flags | Flag.DRY
        try:
            torque = self._send(tick, allowed)
        except Exception as error:  # whatever fails here must end in zero and FAULT
            self._trip_on(error)
            return self._write_zero(decision.torque, flags)
        if torque is None:
            return Sent(torque=ZERO, limited=decision.torque, flags=flags | Flag.NOT_SENT)
        return Sent(torque=torque, limited=decision.torque, flags=flags)

    @property
    def age(self) -> int:
        """Ticks since the last new valid sample."""
        return self._age

    @property
    def shown_angle(self) -> Pair:
        """The newest joint angles (rad), nan before the first sample."""
        return self._joint_angle()

    @property
    def status(self) -> Status:
        """The bits of the pantograph's ``status`` output."""
        bits = Status(0)
        if self.homed:
            bits |= Status.HOMED
        if self.state is State.ACTIVE:
            bits |= Status.ACTIVE
        if self.state is State.FAULT:
            bits |= Status.FAULT
        if self.state is State.ACTIVE and self.permission is not None:
            bits |= Status.OUTPUT_ENABLED
        return bits

    def warnings(self) -> list[str]:
        """What a person has to know before this device produces force."""
        texts: list[str] = []
        if not self.watchdog.verified and not self.in_process:
            none = self.watchdog.timeout is None
            texts.append(
                f"{self.name} has {'no watchdog' if none else 'a watchdog that was never proved'}: "
                "when it is unplugged, hangs or runs away its output is unknown; "
                f"{CUT_POWER.split(':')[0]} then. Keep the switch within reach."
            )
        texts += [
            f"{self.name}: the limit '{name}' is loosened to "
            f"{getattr(self.file.limits, name):g}: {reason}"
            for name, reason in self.file.loosened.items()
        ]
        if not (self.tested_on_hardware or self.in_process):
            texts.append(f"the driver '{self.driver}' has met emulators only, never hardware")
        return texts

    @final
    def _is_let_go(self) -> bool:
        held = None if self.permission is None else self.permission.is_held
        return held is not None and not held()

    @final
    def _check_time(self) -> None:
        if self.pulse is not None and not self.pulse.supervisor_alive():
            self._trip(Trip(Cause.SUPERVISOR, "the supervisor process died"))
        if self._clock is None:
            return
        now = self._clock()
        late = 0.0 if self._written is None else now - self._written - self.tick
        self._written = now
        if late > LATE_SECONDS:
            self._trip(Trip(Cause.LATE, f"the control loop came {late * 1e3:.1f} ms late"))
