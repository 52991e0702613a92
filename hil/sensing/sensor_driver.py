"""What a sensor's driver is: facts of its class, and four calls that send no command."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import ClassVar

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from hil.device.board.driver import BoardDriver
from hil.device.contract import BusUse
from hil.sensing.reading import Heard
from hil.sensing.sensor_file import SensorFile, SensorSettings
from hil.sensing.sensor_preset import SensorPreset
from hil.setup.address import DeviceAddress
from hil.setup.driver_facts import DriverSettings
from hil.setup.registry import GROUP, find


class SensorDriver(BoardDriver, ABC):
    """One protocol on one port, of a board that measures and has nothing to push with.

    Every call but ``open`` is bounded in time; errors are raised as ``DeviceError``.
    """

    measures_only: ClassVar[bool] = True
    command_unit: ClassVar[str | None] = None
    latency_ticks: ClassVar[int] = 1
    settings: ClassVar[type[DriverSettings]] = SensorSettings
    known: ClassVar[Mapping[str, SensorPreset]] = {}
    """The sensors that a file of this driver can name as its ``preset``."""

    def __init__(
        self,
        address: DeviceAddress,
        file: SensorFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        pulse: Pulse | None = None,
        number: int = 0,
    ) -> None:
        super().__init__(address, tick=tick, pulse=pulse, number=number)
        self.file = file

    @classmethod
    def preset_names(cls) -> list[str]:
        """The published sensors that come with it."""
        return sorted(cls.known)

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: SensorFile) -> BusUse | None:
        """The frames of one tick that ``cohaptic check`` counts; ``None`` off a CAN bus."""
        del address, file
        return None

    @abstractmethod
    def open(self) -> None:
        """Open the port; on return the board answers, and has the channels that its file has."""

    @abstractmethod
    def ask(self) -> None:
        """Ask for a sample; the answer is received at the next tick."""

    @abstractmethod
    def receive(self) -> Heard:
        """What has come since the last call."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the port; safe when it was never opened."""


def find_sensor(name: str) -> type[SensorDriver]:
    """A registered sensor driver's class.

    Raises:
        InputError: there is no driver of that name, or it is none of a sensor.
    """
    kind = find(name)
    if not issubclass(kind, SensorDriver):
        raise InputError(
            f"the entry point '{name}' of {GROUP} is no subclass of "
            "hil.sensing.sensor_driver.SensorDriver"
        )
    return kind
