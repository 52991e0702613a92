"""A board whose answers come later than a tick runs at half the rate: it is told, and recorded."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.device.contract import Flag, State
from hil.device.device import Device
from hil.device.punctuality import LARGEST_SHARE, Punctuality
from hil.drivers.haply import driver as module
from hil.drivers.haply.driver import HaplyDriver
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from tests.support.hil.haply_line import Line
from tests.support.hil.motors.haply import Haply

HOME = [2.4, 0.9]
SECONDS = 3


def driven(monkeypatch, late: int) -> tuple[Device, Line, list[tuple[float, float]], list[Flag]]:
    """A device after some seconds of a growing torque, and what it says was sent at each tick."""
    line = Line(Haply(), late)
    monkeypatch.setattr(module, "SerialPort", lambda *_: line)
    monkeypatch.setattr(HaplyDriver, "pause", lambda _: None)
    device = Device(
        HaplyDriver,
        parse("haply:///dev/none"),
        parse_file({"driver": "haply", "home": HOME, "estop": "confirmed"}),
    )
    device.permission = emulated("haply", None)
    device.configure()
    device.home()
    for tick in range(-2 * device.rest_ticks, 0):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
    device.activate()
    line.commands.clear()
    sent, flags = [], []
    for tick in range(1024 * SECONDS):
        device.read(tick)
        told = device.write(tick, (min(tick, 5000) * 4e-6, -0.001))
        sent.append(told.torque)
        flags.append(told.flags)
    assert device.state is State.ACTIVE
    return device, line, sent, flags


def test_a_board_that_is_in_time_is_not_spoken_of(monkeypatch):
    device, line, _, flags = driven(monkeypatch, 0)
    assert device.slowness is None
    assert len(line.commands) == 1024 * SECONDS
    assert not any(flag & Flag.NOT_SENT for flag in flags)


def test_a_late_one_is_told_of_with_its_rate(monkeypatch):
    device, line, _, flags = driven(monkeypatch, 1)
    assert device.slowness is not None
    assert "took 512 commands a second instead of 1024" in device.slowness
    assert len(line.commands) == 512 * SECONDS
    assert sum(bool(flag & Flag.NOT_SENT) for flag in flags) == 512 * SECONDS


@pytest.mark.parametrize("late", [0, 1])
def test_what_it_says_was_sent_is_what_the_motors_were_told(monkeypatch, late: int):
    _, line, sent, flags = driven(monkeypatch, late)
    told, at = iter(line.commands), None
    for torque, flag in zip(sent, flags, strict=True):
        if not flag & Flag.NOT_SENT:
            at = next(told)
        # The board has its motors in the order of its ports: the second joint's first.
        assert at is not None
        assert torque == pytest.approx((at[1], at[0]), abs=1e-12)


@given(st.lists(st.booleans(), min_size=1, max_size=4000))
def test_it_is_late_as_a_rule_or_not_at_all(sent: list[bool]):
    found = Punctuality(1 / 1024)
    for each in sent:
        found.count(sent=each)
    windows = [sent[i : i + 1024] for i in range(0, len(sent) - 1023, 1024)]
    late = any(window.count(False) > LARGEST_SHARE * 1024 for window in windows)
    assert (found.sentence("x") is not None) is late
