"""Heartbeats that stop, an axis gone idle and a bus in trouble are in the fault's sentence."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from cosim.base.errors import InputError
from hil.device.contract import State
from hil.device.device import Device
from hil.device.errors import DeviceError
from hil.drivers.odrive.driver import OdriveDriver
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.wire import can_bus
from hil.wire.can_port import CanFrame, FrameKind
from tests.support.hil.motor_wire import FAKE_BUS

URL = f"odrive+{FAKE_BUS}?nodes=0,1"
HOME = [2.2873, 0.8543]


class Axes:
    """A port with two axes at rest; one look at it is one tick."""

    tells_sent = False

    def __init__(self) -> None:
        self.state = {0: 1, 1: 1}
        self.error = {0: 0, 1: 0}
        self.beats = {0, 1}
        self.deaf: set[int] = set()
        """Axes that do not follow what they are told."""
        self.sent: list[tuple[int, bytes]] = []
        self.measured = {0, 1}
        self.extra: list[CanFrame] = []
        self.ticks = 0
        self._queue: list[CanFrame] | None = None

    def send(self, identifier: int, data: bytes, *, remote: bool) -> None:
        del remote
        self.sent.append((identifier, data))
        if identifier >> 5 in self.deaf:
            return
        if identifier & 0x1F == 0x07:
            (self.state[identifier >> 5],) = struct.unpack("<I", data)

    def receive(self, wait: float) -> CanFrame | None:
        del wait
        if self._queue is None:
            self._queue = list(self._tick())
        if self._queue:
            return self._queue.pop(0)
        self._queue = None
        return None

    def _tick(self) -> Iterator[CanFrame]:
        self.ticks += 1
        yield from self.extra
        for node in (0, 1):
            if node in self.measured:
                yield CanFrame(node << 5 | 0x09, bytes(8))
            if self.ticks % 10 == 0 and node in self.beats:
                told = struct.pack("<IBBBB", self.error[node], self.state[node], 0, 0, 0)
                yield CanFrame(node << 5 | 0x01, told)

    def for_set_up(self) -> Any:
        return contextlib.nullcontext()

    def close(self) -> None: ...


@pytest.fixture
def axes(monkeypatch: pytest.MonkeyPatch) -> Axes:
    made = Axes()
    monkeypatch.setattr(can_bus, "_port", lambda _: made)
    monkeypatch.setattr(can_bus, "_OPEN", {})
    monkeypatch.setattr(OdriveDriver, "pause", lambda _: None)
    return made


@pytest.fixture
def active(axes: Axes) -> Iterator[Callable[..., Device]]:
    """Makes devices that are active on the axes."""
    made: list[Device] = []

    def make(**given: Any) -> Device:
        made.append(_device(**given))
        return _activated(made[-1])

    yield make
    axes.extra, axes.measured = [], {0, 1}
    for device in made:
        device.close()


def _device(watchdog: dict[str, Any] | None = None, **proof: Any) -> Device:
    document: dict[str, Any] = {"driver": "odrive", "home": HOME}
    if watchdog is not None:
        settings = {"watchdog": watchdog, "firmware": proof.pop("firmware", "0.6")}
        document |= {"settings": settings, "watchdog_proof": proof}
    device = Device(OdriveDriver, parse(URL), parse_file(document))
    device.permission = emulated(URL, None)
    return device


def _activated(device: Device) -> Device:
    device.configure()
    device.home()
    exchange(device, device.rest_ticks)
    device.activate()
    exchange(device, 40)
    assert device.state is State.ACTIVE
    return device


def exchange(device: Device, ticks: int) -> int:
    for tick in range(ticks):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
        if device.state is State.FAULT:
            return tick
    return ticks


@pytest.mark.parametrize(
    ("lacks", "says"),
    [
        ({"beats": {0}, "measured": {0}}, "axis 1 was never heard: no axis has that node number"),
        ({"measured": {0}}, "axis 1 sends no encoder estimates"),
        ({"deaf": {0}, "state": {0: 8, 1: 1}}, "axis 0 does not report to be idle"),
    ],
)
def test_a_lone_axis_is_refused_and_what_it_lacks_is_said(axes: Axes, lacks, says: str):
    """One axis of two is no device: it is refused before anything pushes, and left idle."""
    for name, value in lacks.items():
        setattr(axes, name, value)
    device = _device()
    with pytest.raises(DeviceError, match=says):
        device.configure()
    torques = [data for identifier, data in axes.sent if identifier & 0x1F == 0x0E]
    assert set(torques) == {bytes(4)}
    assert all(axes.state[node] == 1 for node in {0, 1} - axes.deaf)


def test_an_axis_that_does_not_follow_into_closed_loop_is_named(axes: Axes):
    device = _device()
    device.configure()
    device.home()
    exchange(device, device.rest_ticks)
    axes.deaf = {1}
    with pytest.raises(DeviceError, match=r"axis 1 does not enter closed loop \(is it calibr"):
        device.activate()
    axes.deaf = set()
    device.close()


def test_one_node_for_two_joints_is_refused():
    with pytest.raises(InputError, match="two different node numbers of 0 to 63, such as 0,1"):
        Device(
            OdriveDriver, parse(URL.replace("0,1", "0")), parse_file({"driver": "odrive"})
        ).configure()


def test_a_heartbeat_that_stops_is_a_fault_within_30_ms(axes: Axes, active):
    device = active()
    axes.beats.discard(1)
    assert exchange(device, 100) <= 40
    assert "heartbeat of ODrive axis 1" in device.fault_sentence()


def test_an_axis_that_goes_idle_is_named(axes: Axes, active):
    device = active()
    axes.state[0] = 1
    assert exchange(device, 100) <= 10
    assert "ODrive axis 0" in device.fault_sentence()
    assert "idle" in device.fault_sentence()


def test_silence_on_a_bus_in_trouble_says_so(axes: Axes, active):
    device = active()
    axes.measured, axes.beats = set(), set()
    axes.extra = [CanFrame(0x20, bytes(8), FrameKind.ERROR)]
    assert exchange(device, 100) == 9
    assert "no valid sample for 10 ticks" in device.fault_sentence()
    assert "nobody acknowledges" in device.fault_sentence()


def test_bus_off_is_named(axes: Axes, active):
    device = active()
    axes.extra = [CanFrame(0x40, bytes(8), FrameKind.ERROR)]
    assert exchange(device, 100) == 0
    assert "bus-off" in device.fault_sentence()


@pytest.mark.parametrize(("timeout", "trusted"), [(0.02, True), (0.1, True), (0.11, False)])
def test_a_watchdog_of_more_than_100_ms_is_none(axes: Axes, active, timeout: float, trusted: bool):
    device = active(
        watchdog={"timeout": timeout}, date="2026-11-22", timeout=timeout, fired_after=timeout
    )
    assert device.watchdog.protects is trusted
    axes.measured, axes.beats = set(), set()
    exchange(device, 20)
    for tick in range(60):
        device.write(tick, (0.0, 0.0))
    said = device.fault_sentence()
    assert ("its own watchdog" in said) is trusted
    assert ("output unknown" in said) is not trusted


@pytest.mark.parametrize(
    ("firmware", "error", "expired"),
    [
        ("0.5", 0x800, True),
        ("0.6", 0x800, False),
        ("0.6", 0x01000000, True),
        ("0.5", 1 << 24, False),
    ],
)
def test_an_expired_watchdog_is_known_by_the_firmware_s_own_bit(
    axes: Axes, active, firmware: str, error: int, expired: bool
):
    proof = {"date": "2026-11-22", "timeout": 0.02, "fired_after": 0.02}
    device = active(watchdog={"timeout": 0.02}, firmware=firmware, **proof)
    axes.error = {0: error, 1: error}
    seen = [device.driver.receive().watchdog_fired for _ in range(12)]
    assert any(seen) is expired
