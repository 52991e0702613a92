"""An answer that is some ticks late is a fault where a Haply pushes, and nothing where it rests.

A handle that nobody pushes yet waits for others to come to rest: three ticks without an answer
ended most starts on a busy machine.
"""

from __future__ import annotations

import pytest

from hil.device.errors import DeviceError
from hil.drivers.haply import driver as module
from hil.drivers.haply.driver import IDLE_TICKS, OUTSTANDING_TICKS, HaplyDriver
from hil.safety.linkage import Pair
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from tests.support.hil.haply_line import Line
from tests.support.hil.motors.haply import Haply

REST, PUSH = (0.0, 0.0), (0.05, -0.03)


def asked(monkeypatch: pytest.MonkeyPatch, torque: Pair) -> tuple[HaplyDriver, Line]:
    """A driver that has asked with that torque, and waits for the answer."""
    line = Line(Haply())
    monkeypatch.setattr(module, "SerialPort", lambda *_: line)
    driver = HaplyDriver(parse("haply:///dev/none"), parse_file({"driver": "haply"}))
    driver.open()
    assert driver.receive().sample is None
    assert driver.send(torque) is not None
    return driver, line


@pytest.mark.parametrize(("torque", "longest"), [(REST, IDLE_TICKS), (PUSH, OUTSTANDING_TICKS)])
def test_it_waits_for_so_many_ticks(monkeypatch, torque: Pair, longest: int):
    assert OUTSTANDING_TICKS == 3 < IDLE_TICKS
    driver, line = asked(monkeypatch, torque)
    answer = line.read()
    for _ in range(longest - 1):
        received = driver.receive()
        assert received.sample is None
        assert not received.zero_confirmed
        assert driver.send(torque) is None, "one question at a time"
    line._answers = answer
    received = driver.receive()
    assert received.sample is not None
    assert received.zero_confirmed is (torque == REST)


@pytest.mark.parametrize(("torque", "longest"), [(REST, IDLE_TICKS), (PUSH, OUTSTANDING_TICKS)])
def test_and_not_for_one_more(monkeypatch, torque: Pair, longest: int):
    driver, line = asked(monkeypatch, torque)
    line.read()
    for _ in range(longest - 1):
        driver.receive()
    with pytest.raises(DeviceError, match=f"no whole answer for {longest} ticks"):
        driver.receive()
