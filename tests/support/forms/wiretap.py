"""What a driver asks for and sends while it opens, with nothing at the other end of the wire."""

from __future__ import annotations

import re
import sys
from contextlib import suppress
from itertools import count
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import can
import serial

from hil.device.board.component import begin_emulated_motion
from hil.device.component import DeviceComponent
from hil.device.errors import DeviceError
from hil.drivers.canopen import driver as canopen
from hil.drivers.canopen import master as canopen_master
from hil.drivers.cia402 import driver as cia402
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from hil.wire import can_bus, serial_port, side_channel, slcan
from hil.wire.python_can import PythonCanPort

MAKERS = {
    "quanser.hardware": ("HILError",),
    "nidaqmx": (),
    "nidaqmx.constants": (),
    "nidaqmx.errors": ("Error",),
    "nidaqmx.system": (),
    "moteus": (),
}


class Wire:
    """Records; what is read from it is nothing."""

    def __init__(self, said: list[Any]) -> None:
        self._said = said

    def send(self, message: Any) -> None:
        self._said.append(("frame", message.arbitration_id, bytes(message.data)))

    def recv(self, timeout: float | None = None) -> None:
        del timeout

    def write(self, data: bytes) -> int:
        self._said.append(("bytes", bytes(data)))
        return len(data)

    def read(self, size: int = 1) -> bytes:
        del size
        return b""

    in_waiting = 0

    def fileno(self) -> int:
        raise OSError("no descriptor: everything goes through here")

    def __getattr__(self, name: str) -> Any:
        return lambda *_, **__: None


def wiretap(monkeypatch: Any, url: str, document: dict[str, Any]) -> list[Any]:
    """Everything that a device's driver asks for and sends: to open, and for one torque."""
    said: list[Any] = []

    def opened(*arguments: Any, **options: Any) -> Wire:
        said.append(("open", arguments, options))
        return Wire(said)

    def set_up(bus: Any, *asked: Any, **more: Any) -> SimpleNamespace:
        del bus
        said.append(("set up", asked, more))
        return SimpleNamespace(ranges=(1 << 20, 1 << 20), rated=(0.2, 0.2), serial=None)

    def side(path: str) -> MagicMock:
        said.append(("side channel", path))
        return MagicMock()

    class Bus(can_bus.CanBus):
        def __init__(self, **given: Any) -> None:
            said.append(("bus", given["budget"], given["bitrate"]))
            super().__init__(**given)

    monkeypatch.setattr(serial, "serial_for_url", opened)
    monkeypatch.setattr(serial_port, "wait_for_board", lambda seconds: said.append(seconds))
    monkeypatch.setattr(can, "Bus", opened)
    monkeypatch.setattr(slcan, "StrictSlcanBus", opened)
    monkeypatch.setattr(can_bus, "CanBus", Bus)
    monkeypatch.setattr(can_bus, "SocketCanPort", lambda channel: PythonCanPort(opened(channel)))
    monkeypatch.setattr(can_bus, "_OPEN", {})
    monkeypatch.setattr(canopen, "set_up", set_up)
    monkeypatch.setattr(cia402, "set_up_drives", set_up)
    monkeypatch.setattr(canopen_master, "SETUP_TICKS", 3)
    clock = count()
    monkeypatch.setattr(canopen_master, "monotonic", lambda: next(clock) * 0.01)
    for module in (side_channel, serial_port):
        monkeypatch.setattr(module, "Control", side)
    monkeypatch.setattr("hil.device.board.component.Control", side)
    makers = _makers(monkeypatch)
    component = DeviceComponent(find(parse(url).driver), url, {})
    said.append(("lock-step", component.lockstep))
    driver = component.kind(component.address, parse_file(document))
    driver.pause = lambda: None
    said.append(("knows its pose", driver.knows_its_pose))
    said.append(("latency", driver.latency_of(driver.address)))
    for call in (
        driver.open,
        driver.receive,
        lambda: driver.set_home((0.5, 0.6)),
        lambda: driver.send((0.01, 0.02)),
    ):
        # Nobody answers: each goes as far as it can.
        with suppress(DeviceError, TypeError, ValueError, AttributeError, AssertionError):
            call()
    begin_emulated_motion(component.address)
    calls = [re.sub(r" id='\d+'", "", str(call)) for call in makers.mock_calls]
    heard = [*said, driver.watchdog, *calls]
    with suppress(DeviceError, TypeError, ValueError, AttributeError, AssertionError):
        driver.close()
    return heard


def _makers(monkeypatch: Any) -> MagicMock:
    made = MagicMock()
    for name, errors in MAKERS.items():
        module = ModuleType(name)
        recorded = getattr(made, name.replace(".", "_"))
        for error in errors:
            setattr(recorded, error, type(error, (Exception,), {}))
        module.__getattr__ = lambda key, recorded=recorded: getattr(recorded, key)
        monkeypatch.setitem(sys.modules, name, module)
    return made
