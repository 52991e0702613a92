"""A force sensor's answer that is whole, and in which one field says what cannot be."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import pytest

from hil.device.contract import State
from hil.device.errors import DeviceError
from hil.drivers.force_sensor import driver as driver_module
from hil.drivers.force_sensor.driver import ForceSensorDriver
from hil.drivers.force_sensor.preset import KNOWN
from hil.drivers.force_sensor.protocol import Answer, Identity
from hil.sensing.sensor import Sensor
from hil.sensing.sensor_file import parse as parse_file
from hil.setup.address import parse
from tests.support.hil.motors.cobs import Cobs
from tests.support.hil.spoiled_replies import framed

END = 2**23 - 1
"""Of the range of the sensor's one channel."""


@dataclass(frozen=True)
class Told:
    """What the board says, as it stands in its frames."""

    status: int = 0
    ahead: int = 0
    """By how much its sequence number is another one."""
    pace: int = 977
    """us a tick."""
    clipped: int = 0
    channels: int = 1
    counts: tuple[int, ...] = (1000,)
    version: int = 1
    serial: int = 7


class Board:
    """In a serial port's place: it answers each question."""

    def __init__(self) -> None:
        self.told, self.time = Told(), 0
        self.answers, self.late = b"", False
        """What was answered; whether it waits for the next answer."""

    def write(self, data: bytes) -> None:
        kind, _, sequence = struct.unpack_from("<BBH", Cobs.unstuffed(data[:-1]))
        now = self.told
        self.time += now.pace
        number = sequence + now.ahead & 0xFFFF
        if kind == 3:
            body = struct.pack("<BBHHI", 0x83, now.channels, number, now.version, now.serial)
        else:
            body = struct.pack(
                f"<BBHIBB{len(now.counts)}i",
                *(0x82, now.status, number, self.time & 0xFFFFFFFF, now.clipped, now.channels),
                *now.counts,
            )
        self.answers += framed(lambda _: body)(Cobs.stuffed(body + b"\0\0") + b"\0")

    def read(self) -> bytes:
        if self.late:
            return b""
        found, self.answers = self.answers, b""
        return found

    def exchange_done(self) -> None: ...

    def close(self) -> None: ...


@pytest.fixture
def board(monkeypatch: pytest.MonkeyPatch) -> Board:
    made = Board()
    monkeypatch.setattr(driver_module, "SerialPort", lambda *_: made)
    monkeypatch.setattr(ForceSensorDriver, "pause", lambda _: None)
    return made


def opened(**values: object) -> Sensor:
    file = parse_file({"driver": "force_sensor", "preset": "load_cell_50n", **values}, KNOWN, "")
    made = Sensor(ForceSensorDriver, parse("force_sensor:///dev/none"), file)
    made.configure()
    return made


@pytest.fixture
def sensor(board: Board) -> Iterator[Sensor]:
    with opened() as made:
        made.ask()
        yield made


CASES = {
    "status: brown-out": (Told(status=1), "brown-out"),
    "status: fault": (Told(status=2), "reports .*FAULT"),
    "status: an unknown bit": (Told(status=64), "reports .*64"),
    "sequence: an old one": (Told(ahead=-9), "no new sample"),
    "sequence: one of the future": (Told(ahead=9), "no new sample"),
    "microseconds: stand still": (Told(pace=0), "clock stands still"),
    "microseconds: begin anew": (Told(pace=-10_000), "clock ran back"),
    "clipped: the channel": (Told(clipped=1), "end of its range"),
    "clipped: one that it has not": (Told(clipped=8), "channel 4 is at the end"),
    "channels: more than there are counts": (Told(channels=3), "no new sample"),
    "channels: none": (Told(channels=0, counts=()), "no new sample"),
    "counts: of two channels": (Told(channels=2, counts=(0, 0)), "2 channels came of a sensor"),
    "counts: at the end of the range": (Told(counts=(END,)), "end of its range"),
    "counts: beyond it, downwards": (Told(counts=(-(2**31),)), "end of its range"),
}


@pytest.mark.parametrize("name", CASES)
def test_an_answer_ends_in_a_fault_with_its_words(name: str, sensor: Sensor, board: Board):
    told, words = CASES[name]
    for tick in range(60):
        if tick == 20:
            assert sensor.state is State.INACTIVE
            board.told = told
        sensor.read()
        sensor.ask()
    assert re.search(words, sensor.fault_sentence()), sensor.fault_sentence()
    assert sensor.wrench.force[2] == pytest.approx(0.0, abs=1e-9), "the last good value"


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name][0].status])
def test_the_older_one_of_two_answers_is_judged_as_well(name: str, sensor: Sensor, board: Board):
    told, words = CASES[name]
    sensor.read()
    board.told, board.late = told, True
    sensor.ask()
    sensor.read()
    assert sensor.state is State.INACTIVE
    board.told, board.late = Told(), False
    sensor.ask()
    sensor.read()
    assert re.search(words, sensor.fault_sentence()), sensor.fault_sentence()


IDENTITIES = {
    "channels": (Told(channels=6), {}, "has 6 channels, its file"),
    "sequence": (Told(ahead=20), {}, "no force sensor answers"),
    "version": (Told(version=2), {}, "speaks version 2"),
    "serial": (Told(serial=7), {"serial": "8"}, "has serial number 7, its file is for 8"),
}


@pytest.mark.parametrize("field", IDENTITIES)
def test_an_identity_that_does_not_fit_is_refused(field: str, board: Board):
    told, values, words = IDENTITIES[field]
    board.told = replace(told)
    with pytest.raises(DeviceError, match=words):
        opened(**values)


def test_every_field_that_is_decoded_is_here():
    assert {field.name for field in fields(Answer)} | {"channels"} == {
        name.partition(":")[0] for name in CASES
    }
    assert {field.name for field in fields(Identity)} == set(IDENTITIES)
