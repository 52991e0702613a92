"""A device: two calls a tick, one order of calls around them, and the only way to its motors.

It has a driver, which speaks the protocol; a safety layer, which limits every torque; a clock of
its samples; a judge of what the board says; and a latch for FAULT. None of them is replaced or
derived from. UNCONFIGURED -> configure -> INACTIVE -> home -> activate -> ACTIVE -> deactivate ->
INACTIVE -> close -> UNCONFIGURED; any error -> FAULT, latched until ``reset``, which un-homes and
closes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, Self, final

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from cosim.base.system.supervised import DeviceCells
from hil.device.alarm import Alarm
from hil.device.board_exchange import FIRST_SAMPLE_TRIES, BoardExchange
from hil.device.conditions import Conditions
from hil.device.contract import ZERO, Flag, Measurement, Sent, State, Status, Watchdog, WriteOutcome
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused, Cause, DeviceError, DeviceFault, LifecycleError
from hil.device.fault_latch import SETTLE_TICKS, FaultLatch
from hil.device.judge import Judge
from hil.device.sample_clock import SampleClock
from hil.safety.layer import SafetyLayer, Trip
from hil.safety.linkage import Pair
from hil.safety.permission import Permission
from hil.safety.safeguards import check_safeguards
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile

LONGEST_NATIVE_PERIOD = 2
"""A device that shows new samples less often than every so many ticks is refused."""
STATES, CAUSES = tuple(State), tuple(Cause)


@final
class Device:
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
        self.state = State.UNCONFIGURED
        self.homed = False
        self.sent_flags = Flag.NONE
        self._latch = FaultLatch()
        self._alarm = alarm or Alarm()
        self._around = Conditions(self.driver.pulse, clock, self._alarm, self.tick)
        self._judge = Judge()
        self._samples = SampleClock(file, oldest=self.safety.ticks.drop)
        self._exchange = BoardExchange(self.driver, self._samples)
        self._reads = 0

    # --- every tick ------------------------------------------------------------------------------

    def read(self, tick: int) -> Measurement:
        """This tick's measurement, or the last one with its age. Never raises on the wire."""
        self._expect("read", State.INACTIVE, State.ACTIVE, State.FAULT)
        self._reads += 1
        samples = self._samples
        samples.tick(fresh=self._take())
        angle, sample = samples.joint_angle(), samples.sample
        if self.state is not State.FAULT and (
            sample is not None or samples.age >= self.safety.ticks.drop
        ):
            known = angle if sample is not None else ZERO
            trip = self.safety.observe(self._reads, known, samples.age, homed=self.homed)
            if trip is not None:
                self._trip(self._explained(trip))
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
        self._expect("write", State.INACTIVE, State.ACTIVE, State.FAULT)
        limited, flags = ZERO, Flag.NONE
        if self.state is State.ACTIVE:
            limited, flags = self._write_active(tick, command)
        if self.state is not State.ACTIVE:
            flags |= self._write_zero()
        if self._exchange.zeroing:
            flags |= Flag.ZEROING
        self.sent_flags = flags
        return Sent(torque=self.sent, limited=limited, flags=flags)

    def _write_active(self, tick: int, command: Pair) -> tuple[Pair, Flag]:
        """What the safety layer left of the command; where that ends in FAULT, nothing was sent."""
        trip = self._around.reason_to_stop(self.permission)
        if trip is not None:
            self._trip(trip)
            return ZERO, Flag.NONE
        decision = self.safety.limit(tick, command)
        if decision.trip is not None:
            self._trip(decision.trip)
            return ZERO, decision.flags
        allowed = decision.torque if self.permission is not None else ZERO
        flags = decision.flags if self.permission is not None else decision.flags | Flag.DRY
        try:
            if not self._exchange.send(allowed):
                flags |= Flag.NOT_SENT
        except Exception as error:  # whatever fails here must end in zero and FAULT
            self._trip_on(error)
        return decision.torque, flags

    def _write_zero(self) -> Flag:
        sent = self._send_zero()
        if self.state is State.FAULT:
            self._latch.settle(self.watchdog, in_process=self.in_process)
        return Flag.NONE if sent else Flag.NOT_SENT

    def _send_zero(self) -> bool:
        """Whether a zero went out, or is known to be there; never raises."""
        try:
            return self._exchange.send_zero()
        except Exception as error:
            self._trip_on(error)
            return False

    def _take(self) -> bool:
        """Receive, and judge what came; whether there was a new valid sample."""
        try:
            received = self._exchange.receive()
        except Exception as error:
            self._trip_on(error)
            return False
        if self.state is not State.FAULT:
            trip = self._judge.verdict(received, self.state)
            if trip is not None:
                self._trip(trip)
        if received.zero_confirmed:
            self._latch.confirm()
        return received.sample is not None

    # --- life cycle ------------------------------------------------------------------------------

    def configure(self) -> None:
        """Open the port and get the device to answer; it commands exact zero from here on.

        Raises:
            DeviceError: it does not answer, or is not the one that the device file describes.
            InputError: the address or the device file cannot be used with this driver.
        """
        self._expect("configure", State.UNCONFIGURED)
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
        self._clear_fault()
        self._samples.restart()
        self._exchange.restart()
        self._judge.forget()
        self.state = State.INACTIVE

    def home(self) -> None:
        """Take the present pose as the home pose of the device file.

        Raises:
            DeviceError: no home pose is known, or no sample comes.
        """
        self._expect("home", State.INACTIVE)
        home = self.file.home
        if home is None and not self.driver.knows_its_pose:
            raise DeviceError(
                f"{self.name} cannot be homed: its device file has no 'home' pose; "
                "measure one with 'cohaptic device calibrate'"
            )
        self.homed = False
        if home is not None:
            self.driver.set_home(home)
            self._wait_for_sample()
            self._samples.set_home(home)
        self.safety.forget()
        self.homed = True

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
        self._judge.start()
        self._around.start()
        self.driver.enter()
        self.state = State.ACTIVE

    def deactivate(self) -> None:
        """Zero, and out of closed loop."""
        self._expect("deactivate", State.ACTIVE)
        self.state = State.INACTIVE
        self._send_zero()
        self.driver.leave()

    def reset(self) -> None:
        """Leave FAULT: the port is closed and the homing is lost, so begin at ``configure``."""
        self._expect("reset", State.FAULT)
        self.driver.close()
        self.state, self.homed = State.UNCONFIGURED, False
        self._clear_fault()

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
        if not was_fault:
            self.state = State.INACTIVE
        self._zero_until_confirmed(SETTLE_TICKS)
        if not was_fault:
            self._guard(self.driver.leave)

    # --- for the supervisor, once the process that wrote is gone ---------------------------------

    def zero_after_death(self, *, torn: bool) -> bool:
        """Send zero until an answer confirms it; whether one did.

        ``torn`` says that the loop died while it was writing a frame.
        """
        try:
            self.driver.take_over()
            if torn:
                self.driver.recover()
            if self._zero_until_confirmed(SETTLE_TICKS):
                return True
            self.driver.recover()
            return self._zero_until_confirmed(2 * SETTLE_TICKS)
        except Exception:  # the answer is "not confirmed", whatever went wrong
            return False

    def release(self) -> None:
        """Let go of the port without a word on the wire."""
        self._guard(self.driver.close)
        self.state, self.homed = State.UNCONFIGURED, False

    # --- what others ask -------------------------------------------------------------------------

    @property
    def sent(self) -> Pair:
        """The torque that was last put on the wire (N.m)."""
        return self._exchange.sent

    @property
    def input_held(self) -> bool:
        """Whether the switch on the board was closed in its newest answer."""
        return self._exchange.input_held

    @property
    def slowness(self) -> str | None:
        """What has to be said of a board that is late as a rule, ``None`` of one in time."""
        return self._exchange.punctuality.sentence(self.name)

    @property
    def rest_ticks(self) -> int:
        """Ticks at zero torque before activation, in which the handle has to rest."""
        return 2 * self.safety.ticks.speed_window

    @property
    def name(self) -> str:
        """What sentences call it."""
        return self.driver.name

    @property
    def watchdog(self) -> Watchdog:
        """What the board does by itself when the host falls silent."""
        return self.driver.watchdog

    @property
    def in_process(self) -> bool:
        """Whether there is no hardware and no other process behind it."""
        return self.driver.in_process

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.driver.lockstep

    @property
    def drops_torque(self) -> bool:
        """Whether its board has a watchdog that was seen to fire, and soon enough."""
        return self.watchdog.protects

    def idle(self) -> None:
        """One exchange at zero torque, before the first tick.

        Raises:
            DeviceFault: it is in FAULT.
        """
        self.read(-1)
        self.write(-1, ZERO)
        self.raise_fault()

    def cells(self) -> DeviceCells:
        """How it stands, as numbers."""
        angle = self.shown_angle
        force = self.file.linkage.tip_force(angle, self.sent)
        return DeviceCells(
            STATES.index(self.state),
            Status.OUTPUT_ENABLED in self.status,
            self.age,
            *angle,
            *self.sent,
            *force,
            self.sent_flags,
            -1 if self.fault is None else CAUSES.index(self.fault.cause),
        )

    @property
    def status(self) -> Status:
        """The bits of the pantograph's ``status`` output."""
        bits = Status.HOMED if self.homed else Status(0)
        if self.state is State.ACTIVE:
            bits |= Status.ACTIVE
            bits |= Status.OUTPUT_ENABLED if self.permission is not None else Status(0)
        return bits | (Status.FAULT if self.state is State.FAULT else Status(0))

    @property
    def status_is_known(self) -> bool:
        """Whether the board has answered since its port was opened."""
        return self._samples.sample is not None

    @property
    def age(self) -> int:
        """Ticks since the last new valid sample."""
        return self._samples.age

    @property
    def shown_angle(self) -> Pair:
        """The newest joint angles (rad), nan before the first sample."""
        return self._samples.joint_angle()

    @property
    def fault(self) -> Trip | None:
        """Why it is in FAULT."""
        return self._latch.fault

    @property
    def outcome(self) -> WriteOutcome | None:
        """What is known of the motors after a fault."""
        return self._latch.outcome

    @property
    def outcome_ticks(self) -> int:
        """Writes from the fault to its outcome."""
        return self._latch.ticks

    @property
    def settled(self) -> bool:
        """Whether it is known what became of the motors after a fault."""
        return self._latch.settled

    def fault_sentence(self) -> str:
        """Why it is in FAULT and what is known of its output."""
        return self._latch.sentence(self.name, self.watchdog)

    def raise_fault(self) -> None:
        """End the run where the device is in FAULT and its outcome is known.

        Raises:
            DeviceFault: always, then.
        """
        if self.state is State.FAULT and self.settled:
            raise DeviceFault(self.fault_sentence())

    # --- inside ----------------------------------------------------------------------------------

    def _zero_until_confirmed(self, ticks: int) -> bool:
        before = self._exchange.zeros
        for _ in range(ticks):
            self._send_zero()
            self.driver.pause()
            self._take()
            if self._exchange.zeros > before:
                return True
        return False

    def _wait_for_sample(self) -> None:
        for _ in range(FIRST_SAMPLE_TRIES):
            self._send_zero()
            self.driver.pause()
            if self._take():
                return
            if self.state is State.FAULT:
                break
        raise DeviceError(
            self.fault_sentence() if self.fault is not None else f"{self.name} does not answer"
        )

    def _expect(self, call: str, *states: State) -> None:
        if self.state not in states:
            wanted = " or ".join(state.value for state in states)
            raise LifecycleError(
                f"{call}: {self.name} is {self.state.value}, it would have to be {wanted}"
            )

    def _explained(self, trip: Trip) -> Trip:
        """With what the driver knows of a silence."""
        known = self.driver.silence() if trip.cause is Cause.STALE else None
        return trip if known is None else Trip(trip.cause, f"{trip.sentence}; {known}")

    def _trip_on(self, error: Exception) -> None:
        cause = error.cause if isinstance(error, DeviceError) else Cause.PORT
        self._trip(Trip(cause, str(error) or type(error).__name__))

    def _trip(self, trip: Trip) -> None:
        if self.state in {State.ACTIVE, State.INACTIVE} and self._latch.set(trip):
            self.state = State.FAULT
            self._alarm.raise_for(self.name)
            if trip.cause.unhomes:
                self.homed = False

    def _clear_fault(self) -> None:
        """What was in FAULT, and was reset or closed, is none of its siblings' business now."""
        if self.fault is not None:
            self._latch.clear()
            self._alarm.withdraw(self.name)

    def _guard(self, call: Callable[[], object]) -> bool:
        """Run a call on a path that must go on; whether it worked."""
        try:
            call()
        except Exception as error:
            self._trip_on(error)
            return False
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
