"""CAN: ODrive's frames on both sides, and the ``slcan`` bus that is used here."""

from __future__ import annotations

import copy
import functools
import socket
from math import isfinite, pi
from types import SimpleNamespace
from typing import Any

from hil.device.contract import State
from hil.device.device import Device
from hil.device.errors import ProtocolError
from hil.drivers.odrive import protocol as odrive
from hil.drivers.odrive.driver import OdriveDriver
from hil.drivers.odrive.emulator import OdriveBoard
from hil.emulation.board import BoardFrame
from hil.emulation.world import World
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.wire.can_bus import CanBus
from hil.wire.python_can import PythonCanPort
from hil.wire.slcan import StrictSlcanBus
from tests.fuzz.script import Script, spoil
from tests.fuzz.wire import TICK, Rest

PLACE = (1.0, 2.0)


def odrive_frames(data: bytes) -> None:
    """Any data field is values or a protocol error."""
    try:
        error, state = odrive.heartbeat(data)
        assert 0 <= error < 2**32
        assert 0 <= state < 256
    except ProtocolError:
        assert len(data) != 8
    try:
        values = odrive.estimates(data)
    except ProtocolError:
        return
    assert len(data) == 8
    assert all(isfinite(value) for value in values)


def odrive_board(data: bytes) -> None:
    """Whatever frames come, the axes' torque is a number, and none without closed loop."""
    script = Script(data)
    board = OdriveBoard(World(Rest(PLACE), lockstep=bool(script.number(2))))
    while script.left:
        identifier = script.number(4) << 5 | script.number(32)
        board.receive(BoardFrame(identifier, script.take(script.number(9))))
        if script.number(4) == 1:
            board.tick()
        assert all(isfinite(torque) for torque in board.world.torque)


def odrive_driver(data: bytes) -> None:
    """Any frames on the bus: a measurement that was sent, or a fault; never an exception."""
    script = Script(data)
    device, bus = _driver()
    for tick in range(1 + script.number(30)):
        sent = []
        for _ in range(script.number(4)):
            identifier, content = script.number(2) << 5 | script.number(32), script.take(8)
            content = content[: 8 - script.number(9) % 9] if script.number(4) == 1 else content
            bus.port.raw.inbox.append((identifier, content))
            sent.append((identifier, content))
        measured = device.read(tick)
        device.write(tick, (0.0, 0.0))
        if measured.sample_age == 0 and device.state is not State.FAULT:
            for node in (0, 1):
                latest = bus.received.latest(
                    odrive.identifier(node, odrive.OdriveCommand.ESTIMATES)
                )
                assert latest is not None
                turns = odrive.estimates(latest[1])[0]
                assert measured.joint_angle[node] == 2 * pi * turns


class FakeBus:
    """python-can's bus with frames that a test puts into it."""

    def __init__(self) -> None:
        self.inbox: list[tuple[int, bytes]] = []

    def send(self, message: Any) -> None: ...

    def recv(self, timeout: float) -> Any:
        if not self.inbox:
            return None
        identifier, data = self.inbox.pop(0)
        return SimpleNamespace(
            arbitration_id=identifier,
            data=data,
            is_remote_frame=False,
            is_extended_id=False,
            is_error_frame=False,
        )

    def shutdown(self) -> None: ...


def _driver() -> tuple[Device, CanBus]:
    return copy.deepcopy(_made())


@functools.cache
def _made() -> tuple[Device, CanBus]:
    device = Device(
        OdriveDriver,
        parse("odrive+fake://can0?lockstep=1"),
        parse_file({"driver": "odrive"}),
        tick=TICK,
    )
    bus = CanBus(
        name="fake", port=PythonCanPort(FakeBus()), key=("fake", "can0"), bitrate=1e6, budget=0.0
    )
    driver: Any = device.driver
    bus.users[driver] = ()
    driver._bus, driver._nodes, driver._sequence, driver._closed = bus, (0, 1), 0, False
    driver._expired_bit, driver._expired = 0x01000000, set()
    driver._silence, driver._silent_ticks, driver._running = {0: 0, 1: 0}, 31, False
    driver._seen, driver._beats, driver._states = {0: 0, 1: 0}, {0: 0, 1: 0}, {0: 0, 1: 0}
    device._life.state = State.INACTIVE
    for node in (0, 1):
        bus.port.raw.inbox.append(
            (odrive.identifier(node, odrive.OdriveCommand.ESTIMATES), bytes(8))
        )
    assert device.read(-1).sample_age == 0, "frames that are in order are read"
    assert device.state is State.INACTIVE, device.fault_sentence()
    return device, bus


def slcan_bus(data: bytes) -> None:
    """Any bytes from an adapter: frames or nothing, and in step at the second line."""
    adapter, bus = _slcan()
    script = Script(data)
    lines = [f"t{0x029 + n:03x}8{n:016x}\r".encode() for n in range(script.number(6))]
    stream = spoil(b"".join(lines), script) + script.rest()
    adapter.sendall(stream[:2000] + b"t1231AB\rt1241CD\r")
    found = []
    while (message := bus.recv(0)) is not None:
        assert message.dlc == len(message.data) <= 8
        assert (message.is_extended_id, message.is_remote_frame, message.is_fd) == (False,) * 3
        found.append((message.arbitration_id, bytes(message.data)))
    assert found[-1] == (0x124, b"\xcd")


@functools.cache
def _slcan() -> tuple[socket.socket, StrictSlcanBus]:
    """An adapter's end of a connection on this machine, and the bus at the other one."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = f"socket://127.0.0.1:{server.getsockname()[1]}"
        bus = StrictSlcanBus(place, sleep_after_open=0.0)
        return server.accept()[0], bus


TARGETS = {
    each.__name__: each
    for each in (
        odrive_frames,
        odrive_board,
        odrive_driver,
        slcan_bus,
    )
}
