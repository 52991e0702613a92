"""What a driver's class declares of itself, for everybody who needs no driver to know it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from cosim.base.document.form import Form
from hil.setup.options import UrlOptions
from hil.setup.preset import Preset

if TYPE_CHECKING:
    from hil.setup.address import DeviceAddress


class DriverSettings(Form):
    """Base of every driver's settings; a driver without any takes this one."""


class DriverFacts:
    """The facts of a driver; ``hil.device.driver.Driver`` adds the calls."""

    driver: ClassVar[str]
    """Its name, as in a URL."""
    latency_ticks: ClassVar[int] = 0
    """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
    native_period_ticks: ClassVar[float] = 1.0
    """How often the device has a new sample, in control ticks."""
    in_process: ClassVar[bool] = False
    """Whether there is no hardware and no other process behind it (``mock``)."""
    shares_port: ClassVar[bool] = True
    """Whether another process can go on with its open port; with a maker's library none can."""
    tested_on_hardware: ClassVar[bool] = False
    measures_only: ClassVar[bool] = False
    """Whether it has nothing to push with: a sensor, which nobody has to permit anything."""
    has_input: ClassVar[bool] = False
    """Whether the board tells of a switch on it, which can serve as a dead-man input."""
    checks_frames: ClassVar[bool] = True
    """Whether a damaged command is noticed; without, the board obeys whatever bytes come."""
    settings: ClassVar[type[DriverSettings]] = DriverSettings
    """The form of ``settings`` in its device file."""
    options: ClassVar[type[UrlOptions]] = UrlOptions
    """The form of the options in its URL."""
    emulator: ClassVar[str | None] = None
    """``module:function`` that makes its emulated board (``hil.emulation.launch``)."""
    presets: ClassVar[Mapping[str, Preset]] = {}
    """The published devices that come with it, by name; every driver's files can name them."""
    preset: ClassVar[str] = "quanser"
    """The one that a device file describes where it does not name one."""
    command_unit: ClassVar[str | None] = "N.m"
    """What it is given: the motor's torque, with ``V`` an amplifier's input, ``None`` for both."""
    found_on: ClassVar[str | None] = None
    """Where ``cohaptic device find`` looks for it: ``serial``, ``can``, or nowhere."""
    usb_ids: ClassVar[tuple[tuple[int, int], ...]] = ()
    """Vendor and product numbers of boards that are known to be this one's."""

    @classmethod
    def preset_names(cls) -> list[str]:
        """The published devices that come with it."""
        return sorted(cls.presets)

    @classmethod
    def latency_of(cls, address: DeviceAddress) -> int:
        """``latency_ticks`` of a device at this address: an option of its URL may add to them."""
        del address
        return cls.latency_ticks
