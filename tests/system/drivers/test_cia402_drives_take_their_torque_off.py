"""CiA 402 drives: what takes the torque off is set and read back, and is seen on the wire.

``Motor`` is a counterpart of its own: it decodes frames as a drive would, by itself.
"""

from __future__ import annotations

import struct

import pytest

from cosim.base.errors import InputError
from hil.device.contract import State
from hil.device.errors import Cause, DeviceError
from hil.drivers.cia402.driver import Cia402Driver
from hil.drivers.cia402.emulator import DrivesBoard
from hil.safety.permission import emulated
from tests.support.hil.canopen_bench import Wire, ready, run

OPTIONS = {0x605A: "quick stop", 0x605B: "shutdown", 0x605C: "disable operation"}
OPTIONS |= {0x605D: "halt", 0x605E: "fault reaction", 0x6007: "lost host"}
LIMIT = 3000
PUSH = (0.02, -0.03)


class Drives(Wire):
    kind = Cia402Driver
    board = DrivesBoard

    def refuse(self, number: int, index: int, kept: int) -> None:
        """The drive keeps another value than it is given."""
        local = self.node(number).local

        def keep(index: int, subindex: int, data: bytes, **_) -> None:
            if index == refused:
                local.data_store[index][subindex] = struct.pack("<h", kept)[: len(data)]

        refused = index
        local.add_write_callback(keep)


class Motor:
    """What a motor does by the frames alone: torque in thousandths, zero unless enabled."""

    def __init__(self, node: int) -> None:
        self.node, self.state, self.torque = node, "off", 0
        self.seen: list[int] = []

    def take(self, identifier: int, data: bytes) -> None:
        if identifier != 0x200 + self.node:
            return
        assert len(data) == 4
        control, target = data[0] | data[1] << 8, int.from_bytes(data[2:], "little", signed=True)
        order = {("off", 6): "ready", ("ready", 7): "on", ("on", 15): "enabled"}
        if not control & 2:
            self.state = "off"
        else:
            self.state = order.get((self.state, control & 15), self.state)
        self.torque = target if self.state == "enabled" else 0
        assert abs(self.torque) <= LIMIT
        self.seen.append(self.torque)


@pytest.fixture
def wire():
    made = Drives((1, 2))
    yield made
    made.close()


def pushing(device, ticks=400):
    """Activated dry, because a thread answers for the board; the torque is let out afterwards."""
    ready(device)
    device.permission = emulated(device.name, None)
    for tick in range(ticks):
        device.read(tick)
        device.write(tick, PUSH)
    assert device.state is State.ACTIVE, device.fault_sentence()


def test_every_option_code_is_written_and_a_drive_is_enabled_step_by_step(wire):
    device = ready(wire.device("1,2"))
    for number in (1, 2):
        value = wire.node(number).value
        assert [value(index, 0) for index in OPTIONS] == [0, 0, 0, 0, 0, 2]
        assert value(0x6061, 0) == 10
        assert value(0x1400, 5) == 20
        assert value(0x1016, 1) & 0xFFFF == 40
        assert value(0x6041, 0) & 0x6F == 0x27
    controls = [f.data[0] for f in wire.seen if f.identifier == 0x201]
    steps = [b for a, b in zip([None, *controls], controls, strict=False) if a != b]
    assert steps[-4:] == [0, 6, 7, 15]
    device.deactivate()
    run(device, 5)
    for number in (1, 2):
        value = wire.node(number).value
        assert (value(0x1400, 5), value(0x1016, 1)) == (0, 0)
        assert value(0x6041, 0) & 0x6F == 0x40


@pytest.mark.parametrize("index", OPTIONS)
def test_an_option_that_does_not_take_the_torque_off_is_refused_by_name(wire, index):
    wire.refuse(2, index, 3)
    with pytest.raises(
        DeviceError, match=f"drive 2 does not take its torque off on '{OPTIONS[index]}'"
    ):
        wire.device("1,2").configure()


@pytest.mark.parametrize(
    ("index", "value", "words"),
    [
        (0x6502, 1, "has no torque mode"),
        (0x6076, 0, "knows no rated torque"),
        (0x6076, 20_000, "too coarse for a limit"),
    ],
)
def test_what_a_drive_lacks_is_named(wire, index, value, words):
    variable = wire.node(2).local.object_dictionary[index]
    variable.default = value
    with pytest.raises(DeviceError, match=words):
        wire.device("1,2").configure()


def test_the_drives_counts_are_compared_with_the_file(wire):
    with pytest.raises(DeviceError, match="counts 20000 in 1 turns"):
        wire.device("1,2", joints=[{"counts_per_turn": 4096}] * 2).configure()


def test_one_node_for_both_joints_is_refused(wire):
    with pytest.raises(InputError, match="two node numbers"):
        wire.device("1").configure()


def test_mode_4_is_used_where_the_file_asks_for_it(wire):
    ready(wire.device("1,2", settings={"mode": 4}))
    value = wire.node(1).value
    assert (value(0x6061, 0), value(0x6087, 0)) == (4, 10_000_000)


@pytest.mark.parametrize(
    ("code", "words"),
    [(0x8250, "commands are missing"), (0x8130, "heartbeat is missing"), (0x2310, "current")],
)
def test_a_nodes_emergency_is_named(wire, code, words):
    device = ready(wire.device("1,2"))
    wire.inject(0x082, struct.pack("<HB5x", code, 1))
    run(device, 3)
    assert device.fault is not None
    assert device.fault.cause is Cause.BOARD
    assert f"CANopen node 2 reports emergency 0x{code:04x}" in device.fault.sentence
    assert words in device.fault.sentence


def test_a_drive_that_is_in_a_fault_without_a_word_is_noticed(wire):
    device = ready(wire.device("1,2"))
    wire.node(1).state = 0x08
    run(device, 3)
    assert device.fault is not None
    assert "drive 1 is in the state 'fault'" in device.fault.sentence


def test_on_the_wire_every_torque_is_within_the_limit_and_the_last_is_zero(wire):
    device = wire.device("1,2")
    pushing(device)
    device.write(400, (float("nan"), 0.0))
    run(device, 3, 401)
    assert device.state is State.FAULT
    motors = Motor(1), Motor(2)
    for frame in wire.seen:
        for motor in motors:
            motor.take(frame.identifier, frame.data)
    for motor, wanted in zip(motors, PUSH, strict=True):
        assert max(map(abs, motor.seen)) <= 1e3 * abs(wanted) / 0.2, "thousandths of 0.2 N.m"
        assert max(map(abs, motor.seen)) > 0
        steps = [abs(b) - abs(a) for a, b in zip(motor.seen, motor.seen[1:], strict=False)]
        assert max(steps) <= 60 / 1024 / 0.2 * 1e3 + 1, "the slew limit"
        assert (motor.state, motor.torque) == ("off", 0)
    assert device.outcome is not None
    assert device.outcome.value == "zero confirmed"


def test_a_drive_whose_host_falls_silent_takes_its_torque_off_by_itself(wire):
    device = wire.device("1,2")
    pushing(device)
    before = wire.boards[0].world.torque
    assert before != (0.0, 0.0)
    for _ in range(24):  # SYNC goes on: another device on the bus sends it
        device.read(0)
    assert wire.boards[0].world.torque == (0.0, 0.0)
    assert device.fault is not None
    assert "0x8250" in device.fault.sentence
