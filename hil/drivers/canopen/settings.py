"""What the device file of a CANopen device says, checked: layout, drives, times."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite

from cosim.base.errors import InputError
from cosim.base.show import show
from hil.drivers.canopen.layout import Layout, layout
from hil.safety.conversion import VoltageDrive
from hil.setup.address import Address
from hil.setup.device_file import DeviceFile

HEARTBEAT_MS, WATCHDOG_MS = 5, 20
"""How often a node and we say that we are alive; how long a node lets us be silent."""
LEAST_WATCHDOG_TICKS = 4
TIMEOUT_SECONDS = 5.0
RESIDUAL_SHARE = 0.01
"""Largest torque at code 0, which outputs drop to by themselves, as a share of the limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """A device's settings."""

    layout: Layout
    drives: tuple[VoltageDrive, VoltageDrive]
    heartbeat_ms: int
    watchdog_ms: int
    timeout: float
    """For an answer during set-up (s)."""
    preset: bool
    """Whether homing writes the encoders' preset values."""

    @property
    def zero_codes(self) -> tuple[int, int]:
        """Output values without torque."""
        return self.drives[0].zero_code, self.drives[1].zero_code


def settings(address: Address, file: DeviceFile, tick: float) -> Settings:
    """The settings of a device with control period ``tick`` (s).

    Raises:
        InputError: one of them cannot be.
    """
    timeout = file.settings.get("timeout", TIMEOUT_SECONDS)
    if isinstance(timeout, bool) or not isinstance(timeout, int | float) or not 0 < timeout <= 600:
        raise InputError(f"'settings.timeout' is a time in s, up to 600; not {show(timeout)}")
    preset = file.settings.get("preset", True)
    if not isinstance(preset, bool):
        raise InputError(f"'settings.preset' is true or false, not {show(preset)}")
    return Settings(
        layout=layout(address, file),
        drives=(_drive(file, 0), _drive(file, 1)),
        heartbeat_ms=max(_milliseconds(file, "heartbeat", HEARTBEAT_MS), ceil(tick * 1e3)),
        watchdog_ms=max(
            _milliseconds(file, "watchdog", WATCHDOG_MS), ceil(LEAST_WATCHDOG_TICKS * tick * 1e3)
        ),
        timeout=float(timeout),
        preset=preset,
    )


def _drive(file: DeviceFile, joint: int) -> VoltageDrive:
    drive = file.joints[joint].drive
    if not isinstance(drive, VoltageDrive):
        raise InputError("a CANopen analogue output takes volts: give 'torque_constant'")
    residual = drive.decode(0)
    if not isfinite(residual) or abs(residual) > RESIDUAL_SHARE * file.limits.torque:
        raise InputError(
            f"an output that drops to code 0 on an error would leave {residual:.4g} N.m with this "
            "'bias': trim the amplifier, so that 0 V is no torque"
        )
    return drive


def _milliseconds(file: DeviceFile, name: str, otherwise: int) -> int:
    value = file.settings.get(name, otherwise)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1000:
        raise InputError(f"'settings.{name}' is a time in whole ms, 1 to 1000; not {show(value)}")
    return value
