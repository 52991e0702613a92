"""Whatever byte a Haply's board has lost, it is brought to zero, and says so, in time.

On motors that were written apart from the driver, which may drop an unknown byte alone or with the
one behind it: the protocol's description does not say.
"""

from __future__ import annotations

import pytest

from hil.device.errors import DeviceError
from hil.device.fault_latch import SETTLE_TICKS
from hil.drivers.haply import driver as module
from hil.drivers.haply.driver import HaplyDriver
from hil.drivers.haply.protocol import HaplyAxis, reset, setup, torques
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from tests.support.hil.haply_line import Line
from tests.support.hil.motors.haply import Haply

PUSH = (0.05, -0.03)


def pushing(monkeypatch, number: int, unknown: int) -> tuple[HaplyDriver, Line]:
    """A driver whose motors push."""
    line = Line(Haply(unknown))
    monkeypatch.setattr(module, "SerialPort", lambda *_: line)
    document = {"driver": "haply", "settings": {"device": number}, "estop": "confirmed"}
    driver = HaplyDriver(parse("haply:///dev/none"), parse_file(document))
    driver.open()
    for _ in range(3):
        driver.receive()
        assert driver.send(PUSH) is not None
    assert line.told[0] != 0.0
    assert driver.receive().sample is not None
    return driver, line


def confirmed(driver: HaplyDriver, line: Line, ticks: int) -> int | None:
    """Ticks until an answer confirms zero, as a device in FAULT goes on; the motors agree."""
    faulted = False
    for tick in range(ticks):
        try:
            received = driver.receive()
        except DeviceError:
            faulted = True
        else:
            if received.zero_confirmed and faulted:
                assert line.told == (0.0, 0.0), "it confirms what is not so"
                return tick
        driver.send_zero()
    return None


AXES = [HaplyAxis(port=2, rotation=1), HaplyAxis(port=1, rotation=1)]
LOST = [("torque", place) for place in range(10)] + [("set-up", place) for place in range(28)]


@pytest.mark.parametrize("unknown", [1, 2])
@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize(("frame", "place"), LOST)
def test_one_lost_byte_is_made_good(monkeypatch, frame: str, place: int, number: int, unknown: int):
    driver, line = pushing(monkeypatch, number, unknown)
    whole = reset(number) + setup(number, AXES) if frame == "set-up" else None
    if whole is None:
        driver.send(PUSH)  # answered; the next one loses a byte
        driver.receive()
        whole = torques(number, driver._axes, PUSH)
    line.write(whole[:place] + whole[place + 1 :])
    driver._outstanding, driver._zero_asked = 1, False
    # A device sees nothing for three ticks, or an odd answer, and is in FAULT then.
    # Numbers 0 and 1 look like types of frames: a longer frame may seem to have begun.
    found = confirmed(driver, line, 4 + (1 if number > 1 else 5) * SETTLE_TICKS)
    if (frame, place, number) != ("torque", 0, 1):  # what is left reads as a very long set-up
        assert found is not None, f"{frame} byte {place}"
