"""CANopen: its frames, nodes under any frames, and the driver on a bus full of noise."""

from __future__ import annotations

import copy
import functools
import logging
import struct
from math import isfinite, pi
from typing import Any

from hil.device.contract import State
from hil.device.device import Device
from hil.device.errors import ProtocolError
from hil.drivers.canopen import driver as module
from hil.drivers.canopen import master
from hil.drivers.canopen import protocol as canopen
from hil.drivers.canopen.driver import CanopenDriver
from hil.drivers.canopen.emulated_node import TORQUE_PER_CODE
from hil.drivers.canopen.emulator import CanopenBoard
from hil.drivers.canopen.set_up import Found
from hil.emulation.board import BoardFrame
from hil.emulation.world import World
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.wire.can_bus import CanBus
from hil.wire.python_can import PythonCanPort
from tests.fuzz.can_targets import FakeBus
from tests.fuzz.script import Script
from tests.fuzz.wire import TICK, Rest

PLACE = (1.0, 2.0)
UNITS = (31831, -12)
LAYOUTS = ((1,), (1, 2), (1, 2, 3))
FROM_NODES = (0x081, 0x181, 0x581, 0x701)
TO_NODES = (0x000, 0x080, 0x201, 0x203, 0x601, 0x603, 0x77F)
LARGEST_TORQUE = 32768 * TORQUE_PER_CODE
logging.getLogger("canopen").setLevel(logging.CRITICAL)
"""The package says what it does not support, a thousand times a second here."""


def canopen_frames(data: bytes) -> None:
    """Any data field is exactly what it says, or a protocol error."""
    parsers = {
        canopen.state: lambda found: canopen.heartbeat(found),
        canopen.emergency: lambda found: (
            struct.pack("<HB", found.code, found.register) + found.vendor
        ),
        lambda field: canopen.positions(field, 2): lambda found: struct.pack("<2i", *found),
    }
    for read, write in parsers.items():
        try:
            found = read(data)
        except ProtocolError:
            continue
        assert write(found) == data
    try:
        answer = canopen.sdo_answer(data)
    except ProtocolError:
        return
    assert len(data) == 8
    assert answer.abort == 0 or answer.value is None


def canopen_board(data: bytes) -> None:
    """Whatever frames come, the outputs stay in their range, and without a start at zero."""
    script = Script(data)
    world = World(Rest(PLACE), lockstep=bool(script.number(2)))
    board = CanopenBoard(world, nodes=LAYOUTS[script.number(3)])
    while script.left:
        number = script.number(len(TO_NODES) + 1)
        identifier = TO_NODES[number] if number < len(TO_NODES) else script.number(0x800)
        for answer in board.receive(BoardFrame(identifier, script.take(script.number(9)))):
            assert board.owns(answer.identifier)
            assert len(answer.data) <= 8
        if script.number(4) == 1:
            board.tick()
        assert all(abs(torque) <= LARGEST_TORQUE for torque in world.torque)


class Answering(FakeBus):
    """A bus with a node that answers SYNC, among frames that a test puts in front of them."""

    def send(self, message: Any) -> None:
        if message.arbitration_id == canopen.SYNC:
            self.inbox.append((0x701, b"\5"))
            self.inbox.append((0x181, struct.pack("<2i", *UNITS)))


def canopen_driver(data: bytes) -> None:
    """Any frames on the bus: the position that answered SYNC, or a fault; never an exception."""
    script = Script(data)
    device, bus = copy.deepcopy(_made())
    for tick in range(1 + script.number(20)):
        for _ in range(script.number(4)):
            number = script.number(2 * len(FROM_NODES))
            identifier = (
                FROM_NODES[number] if number < len(FROM_NODES) else 1 + script.number(0x7FE)
            )
            bus.port.raw.inbox.append((identifier, script.take(script.number(9))))
        measured = device.read(tick)
        device.write(tick, (0.0, 0.0))
        assert measured.count == UNITS
        assert all(isfinite(angle) for angle in measured.joint_angle)
        if device.state is State.FAULT:
            assert device.fault_sentence()
        else:
            assert measured.sample_age == 0


@functools.cache
def _made() -> tuple[Device, CanBus]:
    device = Device(
        CanopenDriver,
        parse("canopen+fake://can0?nodes=1&lockstep=1"),
        parse_file({"driver": "canopen"}),
        tick=TICK,
    )
    bus = CanBus(
        name="fake", port=PythonCanPort(Answering()), key=("fake", "can0"), bitrate=1e6, budget=0.0
    )
    kept = module.set_up, master.open_bus
    module.set_up = lambda *_: Found((1 << 32, 1 << 32), None)
    master.open_bus = lambda *_: bus
    try:
        device.configure()
    finally:
        module.set_up, master.open_bus = kept
    assert device.read(0).joint_angle[0] == 2 * pi * UNITS[0] / 20000
    return device, bus


TARGETS = {each.__name__: each for each in (canopen_frames, canopen_board, canopen_driver)}
