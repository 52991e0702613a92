"""A device: the lifecycle that every driver gets, and the only way to its motors.

A driver fills in the hooks at the end of ``Device`` (``_open``, ``_receive``, ``_send``, ...) and
cannot replace the rest: ``read``, ``write`` and the lifecycle are final, checked when the driver's
class is made. So no torque reaches a hook without the safety layer, and every error becomes FAULT.

UNCONFIGURED -> configure -> INACTIVE -> home -> activate -> ACTIVE -> deactivate -> INACTIVE
-> close -> UNCONFIGURED; any error -> FAULT, latched until ``reset``, which un-homes and closes.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from fractions import Fraction
from typing import Any, ClassVar, Self, final

from cosim.errors import InputError
from hil.address import Address
from hil.contract import (
    CUT_POWER,
    ZERO,
    Cause,
    Flag,
    Measurement,
    Outcome,
    Sample,
    Sent,
    State,
    Status,
    Watchdog,
)
from hil.device_file import DeviceFile
from hil.errors import ActivationRefused, DeviceError, DeviceFault, LifecycleError
from hil.limits import DROP_TICKS, LATE_SECONDS
from hil.linkage import Pair
from hil.permission import Permission
from hil.pulse import Pulse
from hil.safeguards import check_safeguards
from hil.safety import SafetyLayer, Trip

SETTLE_TICKS = 24
"""Ticks after a fault within which a zero has to be confirmed."""
LONGEST_NATIVE_PERIOD = 2
"""A device that shows new samples less often than every so many ticks is refused."""
FIRST_SAMPLE_TRIES = 50
"""Exchanges within which a device has to answer for the first time."""

_FINAL = frozenset(
    {"configure", "home", "activate", "deactivate", "reset", "close", "read", "write", "component"}
    | {"zero_after_death", "_expect", "_check_time", "_joint_angle", "_take", "_trip", "_trip_on"}
    | {"_write_zero", "_settle", "_zero", "_guard"}
)


class Device(ABC):
    """Base of every driver.

    ``tick`` is the control period (s). ``permission`` lets torque out; without one the output is
    dry. ``pulse`` is the supervisor's shared memory, ``None`` without a supervisor. ``clock``
    gives host seconds for the lateness rule; ``None`` (lock-step) counts ticks instead.
    """

    driver: ClassVar[str]
    latency_ticks: ClassVar[int] = 0
    """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
    native_period_ticks: ClassVar[float] = 1.0
    """How often the device has a new sample, in control ticks."""
    in_process: ClassVar[bool] = False
    """Whether there is no hardware and no other process behind it (``mock``)."""
    tested_on_hardware: ClassVar[bool] = False

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        replaced = sorted(_FINAL & set(vars(cls)))
        if replaced:
            message = f"{cls.__name__} replaces {', '.join(replaced)}: drivers fill in hooks only"
            raise TypeError(message)

    def __init__(
        self,
        address: Address,
        file: DeviceFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        permission: Permission | None = None,
        pulse: Pulse | None = None,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self.address = address
        self.file = file
        self.tick = float(tick)
        self.permission = permission
        self.pulse = pulse
        self.name = address.url
        self.number = 0
        """Which device of the run it is, for the supervisor."""
        self.parameters: dict[str, Any] = {}
        """The scenario's pantograph parameters, for what only a simulated device can use."""
        self.state = State.UNCONFIGURED
        self.homed = False
        self.fault: Trip | None = None
        self.outcome: Outcome | None = None
        self.outcome_ticks = 0
        self.stop_requested = False
        self.zeros_confirmed = 0
        self.safety = SafetyLayer(
            file.limits, file.linkage, tick=self.tick, quantum=file.quantum, region=file.region
        )
        self._clock = clock
        self._offset: list[float] = [joint.offset for joint in file.joints]
        self._sample: Sample | None = None
        self._age = DROP_TICKS
        self._reads = 0
        self._written: float | None = None
        self._zeros_before = 0

    @classmethod
    @final
    def component(cls, url: str, options: dict[str, Any]) -> Any:
        """The component that a scenario's ``device: URL`` stands for (entry point contract)."""
        from hil.component import DeviceComponent  # it needs Device itself

        return DeviceComponent(cls, url, options)

    # --- lifecycle -------------------------------------------------------------------------------

    @final
    def configure(self) -> None:
        """Open the port and get the device to answer; it commands exact zero from here on.

        Raises:
            DeviceError: it does not answer, or is not the one that the device file describes.
            InputError: the address or the device file cannot be used with this driver.
        """
        self._expect("configure", State.UNCONFIGURED)
        if self.file.driver != self.driver:
            raise InputError(
                f"the device file is for driver '{self.file.driver}', "
                f"{self.name} is '{self.driver}'"
            )
        if self.native_period_ticks > LONGEST_NATIVE_PERIOD:
            raise InputError(
                f"{self.name} has a new sample every {self.native_period_ticks:g} ticks; more than "
                f"{LONGEST_NATIVE_PERIOD} is too slow for this control rate"
            )
        try:
            self._open()
            self._check_serial()
        except BaseException:
            self._close()
            raise
        self._sample, self._age = None, 0
        self.state = State.INACTIVE

    @final
    def home(self) -> None:
        """Take the present pose as the home pose of the device file.

        Raises:
            DeviceError: no home pose is known, or no sample comes.
        """
        self._expect("home", State.INACTIVE)
        if self.file.home is None and not self.file.settings.get("absolute", False):
            raise DeviceError(
                f"{self.name} cannot be homed: its device file has no 'home' pose; "
                "measure one with 'cohaptic device calibrate'"
            )
        self.homed = False
        if self.file.home is not None:
            self._preset(self.file.home)
            sample = self._fresh_sample()
            for index, joint in enumerate(self.file.joints):
                turned = joint.direction * sample.shaft_angle[index]
                self._offset[index] = self.file.home[index] - turned
        self.safety.forget()
        self.homed = True

    @final
    def activate(self) -> None:
        """Let the device follow commands (with a permission: let it produce torque).

        Raises:
            ActivationRefused: it is not homed, moves, is outside its workspace, or its output is
                not safeguarded.
        """
        self._expect("activate", State.INACTIVE)
        if not self.homed:
            raise ActivationRefused(f"{self.name} is not homed: run 'cohaptic device home'")
        unrest = self.safety.rest()
        if unrest is not None:
            raise ActivationRefused(f"{self.name} cannot be activated: {unrest}")
        if self.permission is not None:
            check_safeguards(self)
        self.safety.start()
        self._written = None
        self._enter()
        self.state = State.ACTIVE

    @final
    def deactivate(self) -> None:
        """Zero, and out of closed loop."""
        self._expect("deactivate", State.ACTIVE)
        self.state = State.INACTIVE
        self._zero()
        self._leave()

    @final
    def reset(self) -> None:
        """Leave FAULT: the port is closed and the homing is lost, so begin at ``configure``."""
        self._expect("reset", State.FAULT)
        self._close()
        self.state, self.homed = State.UNCONFIGURED, False
        self.fault = self.outcome = None

    @final
    def close(self) -> None:
        """Zero the device as well as can be, and let go of it; safe in every state, and twice."""
        if self.state is State.UNCONFIGURED:
            return
        was_fault = self.state is State.FAULT
        try:
            if not was_fault:
                self.state = State.INACTIVE
            before = self.zeros_confirmed
            for _ in range(SETTLE_TICKS):
                if not self._zero():
                    break
                self.pause()
                self._take()
                if self.zeros_confirmed > before:
                    break
            if not was_fault:
                self._guard(self._leave)
        finally:
            self._guard(self._close)
            self.state, self.homed = State.UNCONFIGURED, False

    # --- every tick ------------------------------------------------------------------------------

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
        self._expect("write", State.INACTIVE, State.ACTIVE, State.FAULT)
        if self.state is State.ACTIVE:
            self._check_time()
        if self.state is not State.ACTIVE:
            return self._write_zero(ZERO, Flag.NONE)
        if self.stop_requested:
            self._trip(Trip(Cause.STOPPED, "the run was asked to stop"))
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

    # --- what is known ---------------------------------------------------------------------------

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

    @property
    def watchdog(self) -> Watchdog:
        """What the board does by itself when the host falls silent."""
        return Watchdog()

    @property
    def settled(self) -> bool:
        """Whether it is known what became of the motors after a fault."""
        return self.outcome is not None and self.outcome is not Outcome.PENDING

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.address.options.get("lockstep") == "1"

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

    def warnings(self) -> list[str]:
        """What a person has to know before this device produces force."""
        texts: list[str] = []
        if not self.watchdog.verified and not self.in_process:
            texts.append(
                f"{self.name} has no watchdog: when it is unplugged, hangs or runs away its output "
                f"is unknown; {CUT_POWER.split(':')[0]} then. Keep the switch within reach."
            )
        texts += [
            f"{self.name}: the limit '{name}' is loosened to "
            f"{getattr(self.file.limits, name):g}: {reason}"
            for name, reason in self.file.loosened.items()
        ]
        if not (self.tested_on_hardware or self.in_process):
            texts.append(f"the driver '{self.driver}' has met emulators only, never hardware")
        return texts

    def raise_fault(self) -> None:
        """End the run where the device is in FAULT and its outcome is known.

        Raises:
            DeviceFault: always, then.
        """
        if self.state is State.FAULT and self.settled:
            raise DeviceFault(self.fault_sentence())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- for the supervisor ----------------------------------------------------------------------

    def zero_after_death(self, *, torn: bool) -> bool:
        """Zero a device whose loop died in any place; whether the zero was confirmed.

        Called in the supervisor, which shares nothing with the loop but the open port; ``torn``
        says that the loop died while it was writing a frame.
        """
        before = self.zeros_confirmed
        try:
            self._take_over()
            if torn:
                self._recover()
            for attempt in range(3 * SETTLE_TICKS):
                self._guard(self._send_zero)
                self.pause()
                self._guard(self._receive)
                if self.zeros_confirmed > before:
                    return True
                if attempt == SETTLE_TICKS:
                    self._recover()
        except Exception:  # the answer is "not confirmed", whatever went wrong
            return False
        return False

    def release(self) -> None:
        """Let go of the port without a word on the wire (the supervisor has zeroed it)."""
        self._guard(self._close)
        self.state, self.homed = State.UNCONFIGURED, False

    def pause(self) -> None:
        """One tick's time between exchanges outside the loop; none where no clock is involved."""
        if self.pulse is not None:
            self.pulse.beat()
        if not (self.in_process or self.lockstep):
            time.sleep(self.tick)

    # --- hooks -----------------------------------------------------------------------------------

    @abstractmethod
    def _open(self) -> None:
        """Open and set up; on return the device answers and its torque is zero."""

    @abstractmethod
    def _receive(self) -> Sample | None:
        """The newest valid sample since the last call, or ``None``; bounded in time."""

    @abstractmethod
    def _send(self, tick: int, torque: Pair) -> Pair | None:
        """Send joint torques (N.m); returns them computed back, ``None`` where none went out."""

    @abstractmethod
    def _close(self) -> None:
        """Let go of the port; safe when it was never opened."""

    def _send_zero(self) -> None:
        """Command zero; ``zeros_confirmed`` counts the answers that confirm one."""
        self._send(0, ZERO)

    def _serial(self) -> str | None:
        """The connected device's serial number, ``None`` where it has none to tell."""
        return None

    def _preset(self, home: Pair) -> None:
        """Tell the device its joint angles (rad), where it wants to know them."""

    def _enter(self) -> None:
        """Enter closed loop at zero torque."""

    def _leave(self) -> None:
        """Leave closed loop."""

    def _take_over(self) -> None:
        """Forget what was true in the process that died (answers that it had asked for)."""

    def _recover(self) -> None:
        """Complete or drain a frame that a dead loop left half written."""

    # --- inside ----------------------------------------------------------------------------------

    def _expect(self, call: str, *states: State) -> None:
        if self.state not in states:
            wanted = " or ".join(state.value for state in states)
            raise LifecycleError(
                f"{call}: {self.name} is {self.state.value}, it would have to be {wanted}"
            )

    def _check_serial(self) -> None:
        expected, found = self.file.serial, self._serial()
        if expected is not None and found is not None and expected != found:
            raise DeviceError(
                f"{self.name} has serial number {found}, its device file is for {expected}: "
                "plug in the right one or calibrate this one"
            )

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

    def _fresh_sample(self) -> Sample:
        for _ in range(FIRST_SAMPLE_TRIES):
            self._send_zero()
            self.pause()
            sample = self._receive()
            if sample is not None:
                self._sample = sample
                return sample
        raise DeviceError(f"{self.name} does not answer")

    def _joint_angle(self) -> Pair:
        if self._sample is None:
            return math.nan, math.nan
        first, second = self.file.joints
        shaft = self._sample.shaft_angle
        return (
            first.direction * shaft[0] + self._offset[0],
            second.direction * shaft[1] + self._offset[1],
        )

    def _take(self) -> bool:
        """Receive; whether there was a new valid sample."""
        try:
            sample = self._receive()
        except Exception as error:
            if self.state is not State.FAULT:
                self._trip_on(error)
            return False
        if sample is None:
            return False
        self._sample = sample
        return True

    def _trip_on(self, error: Exception) -> None:
        cause = error.cause if isinstance(error, DeviceError) else Cause.PORT
        self._trip(Trip(cause, str(error) or type(error).__name__))

    def _trip(self, trip: Trip) -> None:
        if self.state is State.FAULT:
            return
        self.state, self.fault, self.outcome = State.FAULT, trip, Outcome.PENDING
        self.outcome_ticks, self._zeros_before = 0, self.zeros_confirmed
        if trip.cause.unhomes:
            self.homed = False

    def _write_zero(self, limited: Pair, flags: Flag) -> Sent:
        sent = self._zero()
        if self.state is State.FAULT and not self.settled:
            self._settle()
            self.outcome_ticks += 0 if self.settled else 1
        return Sent(torque=ZERO, limited=limited, flags=flags if sent else flags | Flag.NOT_SENT)

    def _settle(self) -> None:
        assert self.fault is not None
        confirmed = self.zeros_confirmed > self._zeros_before
        # A device that moved as no command explains is not believed when it says it is at zero.
        if confirmed and (self.in_process or not self.fault.cause.is_motion):
            self.outcome = Outcome.ZERO_CONFIRMED
        elif self.outcome_ticks >= SETTLE_TICKS:
            trusted = self.watchdog.verified and not self.fault.cause.is_motion
            self.outcome = Outcome.WATCHDOG if trusted else Outcome.UNKNOWN

    def _zero(self) -> bool:
        return self._guard(self._send_zero)

    def _guard(self, call: Callable[[], object]) -> bool:
        """Run a hook on a path that must go on; whether it worked."""
        try:
            call()
        except Exception as error:
            if self.state in {State.ACTIVE, State.INACTIVE}:
                self._trip_on(error)
            return False
        return True
