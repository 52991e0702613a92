"""A device: two calls a tick, one order of calls around them, and the only way to its motors.

It has a driver, which speaks the protocol; a safety layer, which limits every torque; a clock of
its samples; a judge of what the board says; and a latch for FAULT. None of them is replaced or
derived from; what they tell is in ``DeviceFacts``.

UNCONFIGURED -> configure -> INACTIVE -> home -> activate -> ACTIVE -> deactivate -> INACTIVE ->
close -> UNCONFIGURED; any error -> FAULT, latched until ``reset``, which un-homes and closes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, Self, final

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from hil.device.board_exchange import BoardExchange
from hil.device.conditions import Conditions
from hil.device.contract import ZERO, Flag, Measurement, Sent, State
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused, Cause, DeviceError, DeviceFault
from hil.device.facts import DeviceFacts
from hil.device.guarded_exchange import GuardedExchange
from hil.device.judge import Judge
from hil.device.life import Alarm, Life
from hil.device.sample_clock import SampleClock
from hil.safety.layer import SafetyLayer, Trip
from hil.safety.linkage import Pair
from hil.safety.permission import Permission
from hil.safety.safeguards import check_safeguards
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile

LONGEST_NATIVE_PERIOD = 2
"""A device that shows new samples less often than every so many ticks is refused."""


@final
class Device(DeviceFacts):
    """One device with a driver of ``kind``.

    ``tick`` is the control period (s). ``permission`` lets torque out; without one the output is
    dry. ``clock`` gives host seconds for the lateness rule; ``None`` (lock-step) counts ticks
    instead. ``pulse``, ``number`` and ``parameters`` are the driver's; the devices of one run share
    an ``alarm``.
    """

    def __init__(
        self,
        kind: type[Driver],
        address: DeviceAddress,
        file: DeviceFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        permission: Permission | None = None,
        pulse: Pulse | None = None,
        clock: Callable[[], float] | None = None,
        number: int = 0,
        parameters: Mapping[str, Any] | None = None,
        alarm: Alarm | None = None,
    ) -> None:
        self.driver = kind(
            address, file, tick=tick, pulse=pulse, number=number, parameters=parameters
        )
        self.address, self.file = address, file
        for sentence in file.limits.beyond_ceilings().values():
            raise InputError(f"{self.name}: {sentence}")
        self.tick = self.driver.tick
        self.permission = permission
        self.safety = SafetyLayer(
            file.limits,
            file.linkage,
            tick=self.tick,
            quantum=file.quantum,
            region=file.region,
        )
        self.sent_flags = Flag.NONE
        self._life = Life(self.driver, alarm or Alarm())
        self._around = Conditions(self.driver.pulse, clock, self._life.alarm, self.tick)
        self._judge = Judge()
        self._samples = SampleClock(file, oldest=self.safety.ticks.drop)
        self._exchange = BoardExchange(self.driver, self._samples)
        self._guarded = GuardedExchange(self._exchange, self._judge, self._life)
        self._reads = 0

    # --- every tick ------------------------------------------------------------------------------

    def read(self, tick: int) -> Measurement:
        """This tick's measurement, or the last one with its age. Never raises on the wire."""
        self._life.expect("read", State.INACTIVE, State.ACTIVE, State.FAULT)
        self._reads += 1
        samples = self._samples
        samples.tick(fresh=self._guarded.take())
        angle, sample = samples.joint_angle(), samples.sample
        if self.state is not State.FAULT and (
            sample is not None or samples.age >= self.safety.ticks.drop
        ):
            known = angle if sample is not None else ZERO
            trip = self.safety.observe(self._reads, known, samples.age, homed=self.homed)
            if trip is not None:
                self._life.trip(self._explained(trip))
        return Measurement(
            joint_angle=angle,
            count=sample.count if sample else (0, 0),
            sequence=sample.sequence if sample else -1,
            sample_age=samples.age,
            status=self.status,
            device_time=samples.device_time,
            host_time=self._around.clock() if self._around.clock else tick * self.tick,
        )

    def write(self, tick: int, command: Pair) -> Sent:
        """Send what the safety layer leaves of a torque command (N.m). Never raises on the wire."""
        self._life.expect("write", State.INACTIVE, State.ACTIVE, State.FAULT)
        limited, flags = ZERO, Flag.NONE
        if self.state is State.ACTIVE:
            limited, flags = self._write_active(tick, command)
        if self.state is not State.ACTIVE:
            flags |= self._guarded.write_zero()
        if self._exchange.zeroing:
            flags |= Flag.ZEROING
        self.sent_flags = flags
        return Sent(torque=self.sent, limited=limited, flags=flags)

    def _write_active(self, tick: int, command: Pair) -> tuple[Pair, Flag]:
        """What the safety layer left of the command; where that ends in FAULT, nothing was sent."""
        trip = self._around.reason_to_stop(self.permission)
        if trip is not None:
            self._life.trip(trip)
            return ZERO, Flag.NONE
        decision = self.safety.limit(tick, command)
        if decision.trip is not None:
            self._life.trip(decision.trip)
            return ZERO, decision.flags
        allowed = decision.torque if self.permission is not None else ZERO
        flags = decision.flags if self.permission is not None else decision.flags | Flag.DRY
        return decision.torque, flags | self._guarded.send(allowed)

    # --- life cycle ------------------------------------------------------------------------------

    def configure(self) -> None:
        """Open the port and get the device to answer; it commands exact zero from here on.

        Raises:
            DeviceError: it does not answer, or is not the one that the device file describes.
            InputError: the address or the device file cannot be used with this driver.
        """
        self._life.expect("configure", State.UNCONFIGURED)
        driver = self.driver
        if self.file.driver != driver.driver:
            raise InputError(
                f"the device file is for driver '{self.file.driver}', "
                f"{self.name} is '{driver.driver}'"
            )
        if driver.native_period_ticks > LONGEST_NATIVE_PERIOD:
            raise InputError(
                f"{self.name} has a new sample every {driver.native_period_ticks:g} ticks; more "
                f"than {LONGEST_NATIVE_PERIOD} is too slow for this control rate"
            )
        driver.watchdog_seen = None
        try:
            driver.open()
            self._exchange.check_serial()
        except BaseException:
            driver.close()
            raise
        self._life.clear_fault()
        self._samples.restart()
        self._exchange.restart()
        self._judge.forget()
        self._life.state = State.INACTIVE

    def home(self) -> None:
        """Take the present pose as the home pose of the device file.

        Raises:
            DeviceError: no home pose is known, or no sample comes.
        """
        self._life.expect("home", State.INACTIVE)
        home = self.file.home
        if home is None and not self.driver.knows_its_pose:
            raise DeviceError(
                f"{self.name} cannot be homed: its device file has no 'home' pose; "
                "measure one with 'cohaptic device calibrate'"
            )
        self._life.homed = False
        self._judge.commanded_anew()  # its watchdog may just have been proved
        if home is not None:
            self.driver.set_home(home)
            self._guarded.wait_for_sample()
            self._samples.set_home(home)
        self.safety.forget()
        self._life.homed = True

    def activate(self) -> None:
        """Let the device follow commands (with a permission: let it produce torque).

        Raises:
            ActivationRefused: it is not homed, moves, is outside its workspace, or its output is
                not safeguarded.
        """
        self._life.expect("activate", State.INACTIVE)
        if not self.homed:
            raise ActivationRefused(f"{self.name} is not homed: run 'cohaptic device home'")
        unrest = self.safety.rest()
        if unrest is not None:
            raise ActivationRefused(f"{self.name} cannot be activated: {unrest}")
        if self.permission is not None:
            check_safeguards(self)
        self.safety.start()
        self._judge.commanded_anew()
        self._around.start()
        self.driver.enter()
        self._life.state = State.ACTIVE

    def deactivate(self) -> None:
        """Zero, and out of closed loop."""
        self._life.expect("deactivate", State.ACTIVE)
        self._life.state = State.INACTIVE
        self._judge.commanded_anew()
        self._guarded.send_zero()
        self.driver.leave()

    def reset(self) -> None:
        """Leave FAULT: the port is closed and the homing is lost, so begin at ``configure``."""
        self._life.expect("reset", State.FAULT)
        self.driver.close()
        self._life.end()
        self._life.clear_fault()

    def close(self) -> None:
        """Zero the device as well as can be, and let go of it; safe in every state, and twice."""
        try:
            self.settle_down()
        finally:
            self.release()

    def settle_down(self) -> None:
        """Zero the device as well as can be, and out of closed loop; its port stays open."""
        if self.state is State.UNCONFIGURED:
            return
        was_fault = self.state is State.FAULT
        self._judge.commanded_anew()
        if not was_fault:
            self._life.state = State.INACTIVE
        self._guarded.zero_until_confirmed()
        if not was_fault:
            self._life.guard(self.driver.leave)

    # --- for the supervisor, once the process that wrote is gone ---------------------------------

    def zero_after_death(self, *, torn: bool) -> bool:
        """Send zero until an answer confirms it; whether one did.

        ``torn`` says that the loop died while it was writing a frame.
        """
        return self._guarded.zero_after_death(torn=torn)

    def release(self) -> None:
        """Let go of the port without a word on the wire."""
        self._life.guard(self.driver.close)
        self._life.end()

    # --- ends of a run ---------------------------------------------------------------------------

    def idle(self) -> None:
        """One exchange at zero torque, before the first tick.

        Raises:
            DeviceFault: it is in FAULT.
        """
        self.read(-1)
        self.write(-1, ZERO)
        self.raise_fault()

    def raise_fault(self) -> None:
        """End the run where the device is in FAULT and its outcome is known.

        Raises:
            DeviceFault: always, then.
        """
        if self.state is State.FAULT and self.settled:
            raise DeviceFault(self.fault_sentence())

    # --- inside ----------------------------------------------------------------------------------

    def _explained(self, trip: Trip) -> Trip:
        """With what the driver knows of a silence."""
        known = self.driver.silence() if trip.cause is Cause.STALE else None
        return trip if known is None else Trip(trip.cause, f"{trip.sentence}; {known}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
