"""A wire between a driver and motors that were written apart from it, tick by tick, with faults.

Two pairs of motors read it. One is the board: it gets what the wire makes of the host's bytes, and
answers. The other reads at the host's own end, so what it was told is what was put on the wire.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import can
import pytest

from hil.device.device import Device
from hil.device.errors import DeviceGone
from hil.drivers.cobs import driver as cobs
from hil.drivers.haply import driver as haply
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from hil.wire import can_bus
from hil.wire.can_port import CanFrame
from tests.support.hil.motors.boards import BOARDS
from tests.support.hil.motors.slcan import Lines, line
from tests.support.hil.motors.told import Told

Pair = tuple[float, float]
SERIAL = {"haply": haply, "cobs": cobs}
HOMES = {"haply": [2.4, 0.9]}
FAKE_BUS = f"fake://of_{os.getpid()}"
"""A bus within this process; who else tests on this machine has its own."""

NODES = {"odrive": "0,1", "canopen": "1", "cia402": "1,2"}


@dataclass(frozen=True)
class WireFault:
    """What the wire and the board do at a tick."""

    lose_answers: bool = False
    lose_command: bool = False
    """A byte of each command; on CAN the frame."""
    flip_answer: bool = False
    spoil: Callable[[bytes], bytes] | None = None
    """What becomes of an answer, whose checksums stay right."""
    flip_command: bool = False
    late: int = 0
    hang: bool = False
    gone: bool = False


SOUND = WireFault()


class MotorWire:
    """In a serial port's place, and below a CAN port."""

    def __init__(self, board: str) -> None:
        self.board = board
        self.motors, self._reader = BOARDS[board](), BOARDS[board]()
        self.now = SOUND
        self.ticks = 0
        self.told = self.on_wire = (0.0, 0.0)
        """Joint torques (N.m) that the motors were last told; that were last put on the wire."""
        self._answers: deque[tuple[int, bytes]] = deque()

    def restart(self) -> None:
        """The board begins anew: it obeys nothing that came before."""
        self.motors, self.told = BOARDS[self.board](), (0.0, 0.0)

    def tick(self) -> None:
        """A tick has passed."""
        self.ticks += 1
        if not self.now.hang:
            self._hear(self.motors.tick())

    def _hear(self, told: list[Told]) -> None:
        for each in told:
            if each.torques is not None:
                self.told = self._joints(each.torques)
            if each.answer and not self.now.lose_answers:
                answer = flipped(each.answer) if self.now.flip_answer else each.answer
                answer = self.now.spoil(answer) if self.now.spoil is not None else answer
                self._answers.append((self.ticks + self.now.late, answer))

    def _joints(self, torques: tuple[float, ...]) -> Pair:
        """In the order of the joints: a Haply's are in the order of its ports."""
        if len(torques) < 2:
            return self.told
        return (torques[1], torques[0]) if self.board == "haply" else (torques[0], torques[1])

    # --- as a serial port ------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        self._refuse_if_gone()
        for each in self._reader.feed(data):
            if each.torques is not None:
                self.on_wire = self._joints(each.torques)
        if self.now.hang:
            return
        if self.now.lose_command:
            data = b"" if self.board in NODES else data[:4] + data[5:]
        elif self.now.flip_command:
            data = flipped(data)
        self._hear(self.motors.feed(data))

    def read(self, most: int = 4096) -> bytes:
        del most
        self._refuse_if_gone()
        found = b""
        while self._answers and self._answers[0][0] <= self.ticks:
            found += self._answers.popleft()[1]
        return found

    def wait(self, count: int, seconds: float) -> bytes:
        del count, seconds
        return self.read()

    def exchange_done(self) -> None: ...

    def take_over(self) -> None: ...

    def close(self) -> None: ...

    def _refuse_if_gone(self) -> None:
        if self.now.gone:
            raise DeviceGone("the port is gone: the other end was closed")


class MotorPort:
    """A CAN port whose frames are lines of text on a wire."""

    tells_sent = False

    def __init__(self, wire: MotorWire) -> None:
        self._wire, self._lines = wire, Lines()
        self._frames: deque[tuple[int, bytes]] = deque()

    def send(self, identifier: int, data: bytes, *, remote: bool) -> None:
        assert not remote
        self._wire.write(line(identifier, data))

    def receive(self, wait: float) -> CanFrame | None:
        del wait
        self._frames += self._lines.frames(self._wire.read())
        return CanFrame(*self._frames.popleft()) if self._frames else None

    def for_set_up(self) -> Any:
        return MotorBus(self)

    def close(self) -> None: ...


class MotorBus(can.BusABC):
    """The same port for a package that wants a bus of python-can."""

    def __init__(self, port: MotorPort) -> None:
        self._port = port
        super().__init__(channel="motors")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        del timeout
        self._port.send(msg.arbitration_id, bytes(msg.data), remote=False)

    def shutdown(self) -> None:
        """Nothing was opened."""
        self._is_shutdown = True

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        frame = self._port.receive(0.0)
        if frame is None:
            time.sleep(0.0005 if timeout else 0.0)
            return None, False
        found = can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=False)
        return found, False


def flipped(data: bytes) -> bytes:
    """The lowest bit of the first byte is another one."""
    return bytes([data[0] ^ 1]) + data[1:]


@contextmanager
def on_motors(name: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Device, MotorWire]]:
    """An active device with output on motors at rest; its ticks pass by ``wire.tick`` alone.

    ``name`` is a board's, with ", pipelined" behind it where it is to be.
    """
    board, _, pipelined = name.partition(", ")
    wire, kind = MotorWire(board), find(board)
    url = f"{board}+{FAKE_BUS}?nodes={NODES[board]}" if board in NODES else f"{board}:///dev/none"
    url += "&pipelined=1" if pipelined else ""
    if board in SERIAL:
        monkeypatch.setattr(SERIAL[board], "SerialPort", lambda *_: wire)
    else:
        monkeypatch.setattr(can_bus, "_port", lambda _: MotorPort(wire))
        monkeypatch.setattr(can_bus, "_OPEN", {})
    monkeypatch.setattr(kind, "pause", lambda _: wire.tick())
    document = {"driver": board, "home": HOMES.get(board, [2.2873, 0.8543])}
    device = Device(kind, parse(url), parse_file(document))
    device.permission = emulated(url, None)
    device.configure()
    device.home()
    for tick in range(-device.rest_ticks, 0):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
        wire.tick()
    device.activate()
    yield device, wire
    wire.now = SOUND
    device.close()
