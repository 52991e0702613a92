"""CANopen boards on a python-can bus in this process: time passes with each SYNC, never by itself.

A thread answers for the boards, so what is tested here is set-up and supervision, not speed.
"""

from __future__ import annotations

import itertools
import threading
from contextlib import suppress
from fractions import Fraction

import can

from hil.device.device import Device
from hil.drivers.canopen.driver import CanopenDriver
from hil.drivers.canopen.emulator import CanopenBoard
from hil.emulation.board import BoardFrame
from hil.emulation.world import World
from hil.safety.linkage import Pair
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file

TICK = Fraction(1, 1024)
REST: Pair = (2.2873, 0.8543)
_channels = itertools.count()


class Puppet:
    """A mechanism that is where the test puts it."""

    def __init__(self) -> None:
        self.place: Pair = REST

    def angle(self) -> Pair:
        return self.place

    def step(self, torque: Pair) -> None: ...

    def start(self) -> None: ...

    def close(self) -> None: ...


class Wire:
    """A bus with boards on it; ``seen`` are the frames that reached them."""

    kind = CanopenDriver
    board = CanopenBoard

    def __init__(self, *devices: tuple[int, ...]) -> None:
        self.channel = f"canopen-{next(_channels)}"
        self.puppets = [Puppet() for _ in devices]
        self.boards = [
            self.board(World(puppet, lockstep=True), nodes=nodes)
            for puppet, nodes in zip(self.puppets, devices, strict=True)
        ]
        self.seen: list[BoardFrame] = []
        self.deaf: set[int] = set()
        """Nodes whose frames are lost."""
        self._devices: list[Device] = []
        self._bus = can.Bus(interface="virtual", channel=self.channel)
        self._other = can.Bus(interface="virtual", channel=self.channel)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def node(self, number: int):
        return next(board._nodes[number] for board in self.boards if number in board._nodes)

    def device(self, nodes: str = "1", **document) -> Device:
        """A device that waits for its answers however long the thread takes."""
        url = f"{self.kind.driver}+virtual://{self.channel}?nodes={nodes}&budget=120"
        settings = {"timeout": 120, **document.pop("settings", {})}
        file = parse_file(
            {"driver": self.kind.driver, "home": list(REST), "settings": settings, **document}
        )
        made = Device(self.kind, parse(url), file, tick=TICK)
        self._devices.append(made)
        return made

    def inject(self, identifier: int, data: bytes) -> None:
        """A frame from somebody else on the bus."""
        self._other.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def close(self) -> None:
        for device in self._devices:
            with suppress(Exception):
                device.release()
        self._end.set()
        self._thread.join()
        self._bus.shutdown()
        self._other.shutdown()

    def _serve(self) -> None:
        while not self._end.is_set():
            message = self._bus.recv(0.02)
            if message is None:
                continue
            frame = BoardFrame(message.arbitration_id, bytes(message.data))
            self.seen.append(frame)
            for board in self.boards:
                answers = board.receive(frame)
                if frame.identifier == 0x080:
                    answers += board.tick()
                for answer in answers:
                    if answer.identifier & 0x7F not in self.deaf:
                        self._bus.send(
                            can.Message(
                                arbitration_id=answer.identifier,
                                data=answer.data,
                                is_extended_id=False,
                            )
                        )


def run(device: Device, ticks: int, start: int = 0):
    """Exchange zeros; the last measurement."""
    measured = None
    for tick in range(start, start + ticks):
        measured = device.read(tick)
        device.write(tick, (0.0, 0.0))
    return measured


def ready(device: Device) -> Device:
    """Configured, homed and active; its output is dry."""
    device.configure()
    device.home()
    run(device, 40, -40)
    device.activate()
    run(device, 5)
    return device
