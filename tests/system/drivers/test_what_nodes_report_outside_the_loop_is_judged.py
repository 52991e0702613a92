"""An emergency is judged while nodes are opened, homed and switched on, as it is in the loop."""

from __future__ import annotations

import struct
from dataclasses import replace

import pytest

from hil.device.device import Device
from hil.device.errors import DeviceError
from tests.support.hil.motor_wire import SOUND, MotorWire, on_motors
from tests.support.hil.spoiled_replies import besides

BURNT = 0x5000
"""An emergency code: device hardware."""


def report(code: int = BURNT):
    return replace(SOUND, spoil=besides(0x081, struct.pack("<HB5x", code, 1)))


@pytest.mark.parametrize("board", ["canopen", "cia402"])
def test_as_they_are_switched_on(board: str, monkeypatch: pytest.MonkeyPatch):
    with on_motors(board, monkeypatch) as (device, wire):
        device.deactivate()
        wire.now = report()
        with pytest.raises(DeviceError, match="node 1 reports emergency 0x5000"):
            device.activate()


def test_as_their_positions_are_preset(monkeypatch: pytest.MonkeyPatch):
    with on_motors("canopen", monkeypatch) as (device, wire):
        device.deactivate()
        wire.now = report()
        with pytest.raises(DeviceError, match="node 1 reports emergency 0x5000"):
            device.home()


@pytest.mark.parametrize("board", ["canopen", "cia402"])
def test_as_they_are_opened(board: str, monkeypatch: pytest.MonkeyPatch):
    with on_motors(board, monkeypatch) as (device, wire):
        again = closed(device, wire)
        wire.now = report()
        with pytest.raises(DeviceError, match="node 1 reports emergency 0x5000"):
            again.configure()


@pytest.mark.parametrize("board", ["canopen", "cia402"])
def test_that_they_had_missed_us_is_no_news(board: str, monkeypatch: pytest.MonkeyPatch):
    with on_motors(board, monkeypatch) as (device, wire):
        wire.now = report(0x8130)
        device.deactivate()
        wire.now = SOUND
        again = closed(device, wire)
        wire.now = report(0x8130)
        again.configure()
        wire.now = SOUND


def closed(device: Device, wire: MotorWire) -> Device:
    """Nothing is left of the first opening but the motors."""
    device.close()
    wire.restart()
    return device
