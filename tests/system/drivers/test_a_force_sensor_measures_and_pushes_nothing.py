"""A force sensor: its force is in the scenario, every reply is judged, only questions leave.

The board of the last tests is a counterpart of its own, which packs its answers by hand.
"""

from __future__ import annotations

import binascii
import json
import os
import struct
import threading
import tty
from math import isnan

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.record.reader import open_run
from hil.device.contract import State
from hil.device.errors import Cause, DeviceError
from hil.device.life import Alarm
from hil.drivers.force_sensor.driver import ForceSensorDriver
from hil.drivers.force_sensor.preset import KNOWN
from hil.emulation.launch import Emulator, Order
from hil.firmware.build import build
from hil.sensing.conform import SENSOR_RULES, SensorBench, conform_sensor
from hil.sensing.sensor import Sensor
from hil.sensing.sensor_file import parse as parse_file
from hil.setup.address import parse
from hil.setup.conform.rule import Conformity

QUANSER = {"device": 0, "initial_tip_position": (0.0425, 0.2)}


def file_of(**values):
    return parse_file({"driver": "force_sensor", **values}, KNOWN, "six_axis")


@pytest.fixture(scope="module")
def firmware(tmp_path_factory) -> str:
    """The C reference of a board that measures."""
    return str(build(tmp_path_factory.mktemp("firmware"), "cohaptic_sensor"))


@pytest.fixture(params=["emulator", "C firmware"])
def emulator(request, firmware):
    options = {"firmware": firmware} if request.param == "C firmware" else {}
    order = Order(name="force_sensor", lockstep=True, parameters=QUANSER, options=options)
    with Emulator(order) as made:
        yield made


def test_the_command_lets_the_c_reference_answer(firmware, monkeypatch):
    built, seen = [], []

    def build_once(folder, name):
        built.append(name)
        return firmware

    def look(made):
        with Sensor(ForceSensorDriver, parse(made.url), file_of()) as sensor:
            sensor.configure()
            seen.append(sensor.state)

    monkeypatch.setattr("hil.firmware.build.build", build_once)
    monkeypatch.setattr(Emulator, "wait", look)
    given = ["device", "emulate", "force_sensor", "--firmware", "--lockstep"]
    CliRunner().invoke(cli, given, catch_exceptions=False)
    assert (built, seen) == (["cohaptic_sensor"], [State.INACTIVE])


@pytest.fixture
def sensor(emulator):
    with Sensor(ForceSensorDriver, parse(emulator.url), file_of(), alarm=Alarm()) as made:
        made.configure()
        made.ask()
        yield made


def exchange(sensor: Sensor, ticks: int) -> list[int]:
    ages = []
    for _ in range(ticks):
        sensor.read()
        sensor.ask()
        ages.append(sensor.age)
    return ages


def test_the_conformance_suite_passes_on_its_emulator(emulator):
    bench = SensorBench(
        kind=ForceSensorDriver,
        address=parse(emulator.url),
        file=file_of(),
        control=emulator.control,
        seconds=0.1,
    )
    results = list(conform_sensor(bench))
    assert len(results) == len(SENSOR_RULES)
    assert {result.outcome for result in results} == {Conformity.KEPT}, results


OUTCOMES = {
    "one answer lost": ("drop", 1, 5, None),
    "answers lost for 5 ticks": ("drop", 5, 5, None),
    "answers lost for good": ("drop", 10**6, 9, Cause.STALE),
    "a bit of every answer flipped": ("corrupt", 10**6, 9, Cause.STALE),
    "board hangs": ("hang", 10**6, 9, Cause.STALE),
    "saturated for 3 ticks": ("saturate", 3, 4, None),
    "saturated for good": ("saturate", 10**6, 10, Cause.MEASUREMENT),
    "brown-out": ("brown-out", 1, 2, Cause.BOARD),
    "restart": ("restart", 2, 3, Cause.RESTARTED),
    "unplugged": ("unplug", 2, 2, Cause.PORT),
}


@pytest.mark.parametrize("fault", OUTCOMES)
def test_every_fault_has_its_outcome(fault, sensor, emulator):
    kind, ticks, within, cause = OUTCOMES[fault]
    exchange(sensor, 20)
    held = sensor.wrench
    emulator.control.ask("fault", kind=kind, ticks=ticks)
    ages = []
    while len(ages) < 24 and sensor.fault is None:
        ages += exchange(sensor, 1)
    assert sensor.wrench == held, "no value that means nothing is ever shown"
    if cause is None:
        assert sensor.state is State.INACTIVE
        assert ages[-1] == 0
        assert max(ages) <= within
        return
    assert sensor.fault is not None
    assert sensor.fault.cause is cause
    assert len(ages) <= within + 1
    assert sensor._alarm.raised_by == sensor.name, "its siblings are brought to zero"
    with pytest.raises(DeviceError, match="pushes nothing"):
        sensor.raise_fault()


SCENARIO = {
    "cohaptic": 1,
    "name": "pushed",
    "duration": "0.1 s",
    "rates": {"control": "1024 Hz"},
    "components": {"finger": {"fmu": "pantograph", "rate": "control", "parameters": QUANSER}},
    "connections": [f"sensor.force[{axis}] -> finger.hand_force[{axis}]" for axis in (1, 2)],
}


def test_its_force_moves_a_simulated_handle_and_is_recorded(tmp_path):
    with Emulator(
        Order(
            name="force_sensor",
            lockstep=True,
            parameters=QUANSER,
            hand={"stiffness": 50.0, "damping": 1.0},
        )
    ) as emulator:
        scenario = {**SCENARIO}
        scenario["components"] = SCENARIO["components"] | {
            "sensor": {"rate": "control", "device": emulator.url}
        }
        path = tmp_path / "pushed.yaml"
        path.write_text(json.dumps(scenario), "utf-8")
        emulator.control.ask("fault", kind="runaway", start=90)  # its own motors move the hand
        done = CliRunner().invoke(
            cli, ["run", str(path), "--out", str(tmp_path / "record"), "--no-figure"]
        )
    assert done.exit_code == 0, done.output
    with open_run(tmp_path / "record") as run:
        force, push = (run[name].values for name in ("sensor.force[2]", "finger.hand_force[2]"))
        moved = run["finger.tip_position[2]"].values
    assert np.abs(force).max() > 0.05, "the emulated hand is pulled by its own device"
    assert np.array_equal(force, push)
    assert np.ptp(moved) > 0


def test_a_run_with_a_sensor_alone_has_nothing_to_enable(tmp_path):
    path = tmp_path / "sensor.yaml"
    components = {"sensor": {"rate": "control", "device": "force_sensor:///dev/null"}}
    path.write_text(json.dumps({**SCENARIO, "components": components, "connections": []}), "utf-8")
    done = CliRunner().invoke(cli, ["run", str(path), "--enable-output", "--realtime"])
    assert "no device that pushes" in str(done.exception)


class Wire:
    """A board of its own on a pseudo-terminal: it remembers every byte that it was sent."""

    def __init__(self, counts, *, channels=None, zero_clock=False, serial=7):
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.url = f"force_sensor://{os.ttyname(self._slave)}"
        self.counts, self.serial, self.heard = counts, serial, b""
        self.is_silent = False
        self.answered = threading.Event()
        self._channels = len(counts) if channels is None else channels
        self._time = 0
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        while data := self._read():
            self.heard += data
            for part in data.split(b"\0")[:-1]:
                self._answer(unstuffed(part))
                self.answered.set()

    def _read(self):
        try:
            return os.read(self._master, 4096)
        except OSError:
            return b""

    def _answer(self, question):
        self._time += 977
        if self.is_silent:
            return
        sequence = question[2:4]
        body = struct.pack("<BB", 0x83, self._channels) + sequence
        body += struct.pack("<HI", 1, self.serial)
        if question[0] == 2:
            body = struct.pack("<BB", 0x82, 0) + sequence
            body += struct.pack("<IBB", self._time, 0, len(self.counts))
            body += struct.pack(f"<{len(self.counts)}i", *self.counts)
        whole = body + struct.pack(">H", binascii.crc_hqx(body, 0xFFFF))
        os.write(self._master, stuffed(whole) + b"\0")

    def pause(self):
        """Until it has answered, however busy the machine is."""
        self.answered.wait(1)
        self.answered.clear()

    def close(self):
        os.close(self._slave)
        self._thread.join(1)
        os.close(self._master)


def stuffed(data):
    out, block = b"", b""
    for byte in data + b"\0":
        if byte:
            block += bytes([byte])
        else:
            out, block = out + bytes([len(block) + 1]) + block, b""
    return out


def unstuffed(data):
    out = b""
    while data:
        size, out = data[0], out + data[1 : data[0]]
        data = data[size:]
        out += b"\0" if data else b""
    return out


def opened(board, **values):
    made = Sensor(ForceSensorDriver, parse(board.url), file_of(**values))
    made.driver.pause = board.pause
    made.configure()
    return made


def settled(sensor):
    for _ in range(4):
        sensor.ask()
        sensor.driver.pause()
        sensor.read()
    return sensor.wrench


@pytest.fixture
def wired(request):
    boards = []

    def make(*arguments, **options):
        boards.append(Wire(*arguments, **options))
        return boards[-1]

    yield make
    for board in boards:
        board.close()


LOAD_CELL = {"preset": "load_cell_50n"}


def test_counts_become_newtons_and_what_nothing_measures_is_no_number(wired):
    board = wired((1000,))
    with opened(board, **LOAD_CELL) as sensor:
        board.counts = (1000 + (2**23 - 1) // 20,)  # a tenth of its rating
        force = settled(sensor).force
    assert force[2] == pytest.approx(5.0, rel=1e-5)
    assert isnan(force[0])
    assert isnan(force[1])


def test_what_was_in_fault_is_opened_again_and_its_siblings_may_push(wired):
    board, alarm = wired((1000,)), Alarm()
    sensor = Sensor(ForceSensorDriver, parse(board.url), file_of(**LOAD_CELL), alarm=alarm)
    sensor.driver.pause = board.pause
    for _ in range(2):
        with sensor:
            sensor.configure()
            assert (sensor.fault, alarm.raised_by) == (None, None)
            assert settled(sensor).force[2] == pytest.approx(0.0)
            board.is_silent = True
            for _ in range(40):
                sensor.ask()
                sensor.read()
            assert sensor.fault is not None
            assert alarm.raised_by == sensor.name
        board.is_silent = False


def test_only_questions_are_ever_sent(wired):
    board = wired((0,))
    with opened(board, **LOAD_CELL) as sensor:
        settled(sensor)
    frames = [unstuffed(part) for part in board.heard.split(b"\0") if part]
    assert len(frames) > 60
    assert {(frame[:2], len(frame)) for frame in frames} == {(b"\x02\0", 6), (b"\x03\0", 6)}


def test_a_loaded_sensor_is_not_tared(wired):
    with pytest.raises(DeviceError, match="take the load off"):
        opened(wired((3_000_000,)), **LOAD_CELL)


def test_tare_false_shows_the_load_as_it_is(wired):
    with opened(wired((419_430,)), **LOAD_CELL, settings={"tare": False}) as sensor:
        assert settled(sensor).force[2] == pytest.approx(5.0, rel=1e-5)


def test_another_number_of_channels_is_refused(wired):
    with pytest.raises(DeviceError, match=r"has 1 channels, its file .* has 6"):
        opened(wired((0,)))


def test_answers_with_other_channels_than_announced_are_refused(wired):
    with pytest.raises(DeviceError, match="2 channels came of a sensor that has 1"):
        opened(wired((0, 0), channels=1), **LOAD_CELL)


def test_another_sensor_is_refused(wired):
    with pytest.raises(DeviceError, match="has serial number 7, its file is for 8"):
        opened(wired((0,)), **LOAD_CELL, serial="8")


@pytest.mark.parametrize(
    ("channel", "words"),
    [
        ({"full_scale": 1000}, "it would measure nothing"),
        ({"full_scale": 2**23, "force": ["1 N", 0, 0]}, "is the unit of"),
        ({"full_scale": 1000, "force": [0.01, 0, 0], "zero": 1000}, "at the end of its range"),
        ({"full_scale": 1000, "force": ["1 m", 0, 0]}, "Write a force per count"),
        ({"full_scale": 1000, "force": [0.01, 0, 0], "gain": 2}, "unknown key 'gain'"),
    ],
)
def test_an_implausible_channel_is_refused_with_its_place(channel, words):
    with pytest.raises(InputError, match=words) as caught:
        file_of(settings={"channels": [channel]})
    assert "channels" in str(caught.value)


def test_an_unknown_preset_is_answered_with_the_nearest():
    with pytest.raises(InputError, match="Did you mean six_axis"):
        file_of(preset="six_axes")
