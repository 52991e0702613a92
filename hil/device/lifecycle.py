"""The life of a device, one order of calls for every driver.

UNCONFIGURED -> configure -> INACTIVE -> home -> activate -> ACTIVE -> deactivate -> INACTIVE
-> close -> UNCONFIGURED; any error -> FAULT, latched until ``reset``, which un-homes and closes.
"""

from __future__ import annotations

from functools import cached_property
from typing import Self, final

from cosim.base.errors import InputError
from hil.device.contract import State
from hil.device.errors import ActivationRefused, DeviceError
from hil.device.fault_latch import SETTLE_TICKS
from hil.device.measuring import Measuring
from hil.safety.layer import SafetyLayer
from hil.safety.safeguards import check_safeguards

LONGEST_NATIVE_PERIOD = 2
"""A device that shows new samples less often than every so many ticks is refused."""


class Lifecycle(Measuring):
    """Which call is allowed when, and what has to hold before a device may produce force."""

    _written: float | None = None
    """Host time (s) of the last write while ACTIVE."""

    @cached_property
    @final
    def safety(self) -> SafetyLayer:
        """What stands between command and motor."""
        return SafetyLayer(
            self.file.limits,
            self.file.linkage,
            tick=self.tick,
            quantum=self.file.quantum,
            region=self.file.region,
        )

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
        if self.file.home is None and not self.knows_its_pose:
            raise DeviceError(
                f"{self.name} cannot be homed: its device file has no 'home' pose; "
                "measure one with 'cohaptic device calibrate'"
            )
        self.homed = False
        if self.file.home is not None:
            self._preset(self.file.home)
            self._set_home(self.file.home)
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

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @final
    def _check_serial(self) -> None:
        expected, found = self.file.serial, self._serial()
        if expected is not None and found is not None and expected != found:
            raise DeviceError(
                f"{self.name} has serial number {found}, its device file is for {expected}: "
                "plug in the right one or calibrate this one"
            )
