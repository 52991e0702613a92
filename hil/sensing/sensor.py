"""A sensor: read every tick, judged as a device is, with nothing that could be commanded.

Answers are a tick behind. A value at the end of its range is no value: the last good one is held
while it ages, and from the age on at which a device is brought to zero the sensor is in FAULT,
which ends the run and brings every device of it to zero.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import nan
from typing import Self, final

from cosim.base.system.pulse import Pulse
from cosim.base.system.supervised import DeviceCells
from hil.device.contract import Flag, Received, State
from hil.device.errors import Cause, DeviceError, DeviceFault
from hil.device.facts import CAUSES, STATES
from hil.device.judge import Judge
from hil.device.life import Alarm
from hil.safety.layer import Trip
from hil.safety.limits import TickLimits
from hil.sensing.reading import SensorStatus, Wrench
from hil.sensing.sensor_driver import SensorDriver
from hil.sensing.sensor_file import SensorFile
from hil.sensing.sensor_preset import LoadChannel
from hil.sensing.tare import TARE_SAMPLES, tared
from hil.setup.address import DeviceAddress

FIRST_TRIES = 50
UNKNOWN = Wrench((nan, nan, nan), (nan, nan, nan))


@final
class Sensor:
    """One sensor with a driver of ``kind``. ``alarm`` is shared by the devices of a run."""

    in_process = False
    drops_torque = True
    """It has none."""
    slowness: str | None = None

    def __init__(
        self,
        kind: type[SensorDriver],
        address: DeviceAddress,
        file: SensorFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        pulse: Pulse | None = None,
        number: int = 0,
        alarm: Alarm | None = None,
    ) -> None:
        self.driver = kind(address, file, tick=tick, pulse=pulse, number=number)
        self.file, self.tick = file, self.driver.tick
        self.state = State.UNCONFIGURED
        self.wrench, self.age = UNKNOWN, 0
        self.fault: Trip | None = None
        self.device_time: float | None = None
        self._clipped: tuple[int, ...] = ()
        self._alarm = alarm or Alarm()
        self._judge = Judge()
        self._drop = TickLimits.at(self.tick).drop
        self._zeros = tuple(float(channel.zero) for channel in file.channels)
        self._measured = _axes(file.channels)

    # --- every tick ------------------------------------------------------------------------------

    def read(self) -> Wrench:
        """This tick's wrench, or the last good one; :attr:`age` says how old. Never raises."""
        counts = self._take()
        if counts is None:
            self.age += 1
        else:
            self.wrench, self.age = self._wrench(counts), 0
        if self.age >= self._drop and self.state is State.INACTIVE:
            self._trip(self._silence())
        return self.wrench

    def ask(self) -> None:
        """Ask for the sample that the next tick reads. Never raises on the wire."""
        if self.state is State.FAULT:
            return
        try:
            self.driver.ask()
        except Exception as error:  # whatever fails here must end in FAULT
            self._trip_on(error)

    def _take(self) -> tuple[int, ...] | None:
        """The counts that came, where they are fit for use."""
        if self.state is State.FAULT:
            return None
        try:
            heard = self.driver.receive()
        except Exception as error:
            self._trip_on(error)
            return None
        *earlier, newest = (
            Received(device_time=each.device_time, error=each.error) for each in heard.each
        )
        trip = self._judge.verdict(replace(newest, earlier=tuple(earlier)), self.state)
        if trip is not None:
            self._trip(trip)
            return None
        self.device_time = heard.device_time if heard.device_time is not None else self.device_time
        if heard.counts is None:
            return None
        ends = enumerate(zip(heard.counts, self.file.channels, strict=True))
        full = {index for index, (count, each) in ends if abs(count) >= each.full_scale}
        self._clipped = tuple(sorted(full | heard.clipped))
        return None if self._clipped else heard.counts

    def _silence(self) -> Trip:
        if self._clipped:
            channels = ", ".join(str(index + 1) for index in self._clipped)
            return Trip(
                Cause.MEASUREMENT,
                f"channel {channels} has stood at the end of its range for {self.age} ticks: the "
                "load is beyond what it measures, or a wire is broken",
            )
        return Trip(Cause.STALE, f"no new sample for {self.age} ticks")

    def _wrench(self, counts: tuple[int, ...]) -> Wrench:
        force, torque = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        for count, zero, channel in zip(counts, self._zeros, self.file.channels, strict=True):
            load = count - zero
            for axis in range(3):
                force[axis] += load * channel.force[axis]
                torque[axis] += load * channel.torque[axis]
        for axis in range(3):
            force[axis] = force[axis] if self._measured[axis] else nan
            torque[axis] = torque[axis] if self._measured[3 + axis] else nan
        return Wrench((force[0], force[1], force[2]), (torque[0], torque[1], torque[2]))

    # --- life cycle ------------------------------------------------------------------------------

    def configure(self) -> None:
        """Open the port, see samples come, and tare where the file says so.

        Raises:
            DeviceError: it does not answer, is another one, or is loaded while it is to be tared.
            InputError: the address cannot be used.
        """
        if self.fault is not None:  # of the last opening; its siblings may go on
            self.fault = None
            self._alarm.withdraw(self.name)
        try:
            self.driver.open()
            self._check_serial()
            self.state = State.INACTIVE
            self._judge.forget()
            self._await_sample()
            if self.file.tare:
                self._tare()
        except BaseException:
            self.close()
            raise

    def _check_serial(self) -> None:
        expected, found = self.file.serial, self.driver.serial()
        if expected is not None and found is not None and expected != found:
            raise DeviceError(
                f"{self.name} has serial number {found}, its file is for {expected}: plug in the "
                "right one or calibrate this one"
            )

    def _await_sample(self) -> None:
        for _ in range(FIRST_TRIES):
            if self._next() is not None:
                return
            if self.state is State.FAULT:
                break
        raise DeviceError(self.fault_sentence() if self.fault else self._why_none())

    def _why_none(self) -> str:
        if self._clipped:
            return f"{self.name}: {self._silence().sentence}"
        return f"{self.name} sends no samples"

    def _tare(self) -> None:
        rows = [row for _ in range(TARE_SAMPLES) if (row := self._next()) is not None]
        self.raise_fault()
        self._zeros = tared(self.name, self.file.channels, rows)

    def _next(self) -> tuple[int, ...] | None:
        """One exchange outside the loop."""
        self.ask()
        self.driver.pause()
        counts = self._take()
        if counts is not None:
            self.wrench, self.age = self._wrench(counts), 0
        return counts

    def close(self) -> None:
        """Let go of the port; safe in every state, and twice."""
        self.driver.close()
        self.state = State.UNCONFIGURED

    release = close

    def idle(self) -> None:
        """One exchange before the first tick.

        Raises:
            DeviceFault: it is in FAULT.
        """
        self.read()
        self.ask()
        self.raise_fault()

    def zero_after_death(self, *, torn: bool) -> bool:
        """There is nothing to bring to zero."""
        del torn
        return True

    # --- what others ask -------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """What sentences call it."""
        return self.driver.name

    @property
    def latency_ticks(self) -> int:
        """How many ticks old a new sample is."""
        return self.driver.latency_of(self.driver.address)

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.driver.lockstep

    @property
    def status(self) -> SensorStatus:
        """The bits of its ``status`` output."""
        bits = SensorStatus.FAULT if self.state is State.FAULT else SensorStatus(0)
        bits |= SensorStatus.OPEN if self.state is not State.UNCONFIGURED else SensorStatus(0)
        return bits | (SensorStatus.SATURATED if self._clipped else SensorStatus(0))

    def cells(self) -> DeviceCells:
        """How it stands; the force is the measured one."""
        force = self.wrench.force
        cause = -1 if self.fault is None else CAUSES.index(self.fault.cause)
        return DeviceCells(
            STATES.index(self.state),
            0,
            self.age,
            nan,
            nan,
            0.0,
            0.0,
            force[0],
            force[1],
            Flag.NONE,
            cause,
        )

    def fault_sentence(self) -> str:
        """Why it is in FAULT."""
        if self.fault is None:
            return f"{self.name} is not in FAULT"
        return (
            f"{self.name} is in FAULT ({self.fault.cause}): {self.fault.sentence}; it measures "
            "only and pushes nothing"
        )

    def raise_fault(self) -> None:
        """End the run where the sensor is in FAULT.

        Raises:
            DeviceFault: always, then.
        """
        if self.state is State.FAULT:
            raise DeviceFault(self.fault_sentence())

    def _trip_on(self, error: Exception) -> None:
        cause = error.cause if isinstance(error, DeviceError) else Cause.PORT
        self._trip(Trip(cause, str(error) or type(error).__name__))

    def _trip(self, trip: Trip) -> None:
        if self.state is State.INACTIVE and self.fault is None:
            self.fault, self.state = trip, State.FAULT
            self._alarm.raise_for(self.name)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _axes(channels: tuple[LoadChannel, ...]) -> tuple[bool, ...]:
    """Which of force x, y, z and torque x, y, z any channel measures."""
    return tuple(
        any((*channel.force, *channel.torque)[axis] for channel in channels) for axis in range(6)
    )
