"""What the rules of the conformance suite work with: openings of a device, and who moves it."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hil.device.component import observe_rest
from hil.device.contract import Received
from hil.device.device import Device
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused
from hil.safety.permission import Permission
from hil.setup.address import DeviceAddress
from hil.setup.calibrate.turner import Turner
from hil.setup.conform.errors import NotTried
from hil.setup.device_file import DeviceFile
from hil.setup.watchdog_proof import prove_at_opening
from hil.wire.side_channel import Control

EXCHANGES = 24
"""Exchanges within which a board has to do what it was told."""


@dataclass(slots=True, kw_only=True)
class ConformBench:
    """One board on one bench.

    ``turner`` turns its joints, ``ask`` asks a person (``None`` for an emulator), ``control`` is
    an emulator's side channel, and ``permission`` says whether its output stage may be on.
    """

    kind: type[Driver]
    address: DeviceAddress
    file: DeviceFile
    turner: Turner
    ask: Callable[[str], str] | None
    control: Control | None
    permission: Permission | None
    seconds: float
    """How long samples are counted."""

    @contextmanager
    def opened(self) -> Generator[Device]:
        """The device, configured; closed afterwards, with zero."""
        device = Device(self.kind, self.address, self.file, permission=self.permission)
        device.configure()
        try:
            yield device
        finally:
            device.close()

    @contextmanager
    def active(self) -> Generator[Device]:
        """The device, homed where it stands, seen at rest, and ACTIVE.

        Raises:
            NotTried: it may not be active here: nothing would switch it off.
        """
        with self.opened() as device:
            prove_at_opening(device)
            if self.ask is not None and self.file.home is not None:
                self.ask("Hold the handle at its home pose and press Enter: ")
            device.home()
            observe_rest(device)
            try:
                device.activate()
            except ActivationRefused as refused:
                raise NotTried(str(refused)) from None
            yield device

    def truth(self) -> dict[str, Any] | None:
        """What the emulated board really does; ``None`` for a real one."""
        return None if self.control is None else self.control.ask("state")

    def do(self, request: str, emulated: str, **values: Any) -> None:
        """Have an emulator do something (``emulated``), or a person (``request``)."""
        if self.control is not None:
            self.control.ask(emulated, **values)
            return
        if self.ask is None:
            raise NotTried("nobody is there to do it")
        self.ask(f"{request} and press Enter: ")


def idle(driver: Driver) -> Received:
    """One exchange with the output stage off."""
    driver.send_zero()
    driver.pause()
    return driver.receive()


def fed(driver: Driver) -> Received:
    """One exchange at zero torque that keeps the board's watchdog from firing."""
    driver.feed()
    driver.pause()
    return driver.receive()


def silent(driver: Driver, ticks: int) -> list[Received]:
    """Ticks in which nothing is sent."""
    heard: list[Received] = []
    for _ in range(ticks):
        driver.pause()
        heard.append(driver.receive())
    return heard
