"""A serial line without a system: a driver's port whose other end is an emulated board, here."""

from __future__ import annotations

import copy
import functools
import importlib
from collections.abc import Callable
from fractions import Fraction

from hil.device.contract import ZERO
from hil.device.device import Device
from hil.drivers.cobs.emulator import CobsBoard
from hil.drivers.haply.emulator import HaplyBoard
from hil.emulation.board import Board
from hil.emulation.world import World
from hil.safety.linkage import Pair
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find

TICK = Fraction(1, 1024)
Spoiler = Callable[[bytes], bytes]


class Rest:
    """A mechanism that stays where it is."""

    def __init__(self, place: Pair) -> None:
        self.place = place

    def angle(self) -> Pair:
        return self.place

    def step(self, torque: Pair) -> None: ...

    def start(self) -> None: ...

    def close(self) -> None: ...


class Wire:
    """What a driver takes for its ``SerialPort``; both directions can be spoiled."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.to_board: Spoiler = bytes
        self.to_host: Spoiler = bytes
        """What happens to bytes on their way."""
        self._inbox = b""

    def write(self, frame: bytes) -> None:
        answers = self.board.receive(self.to_board(frame))
        for answer in answers:
            assert isinstance(answer, bytes)
            self._inbox += self.to_host(answer)
        self.board.tick()

    def read(self, most: int = 4096) -> bytes:
        data, self._inbox = self._inbox[:most], self._inbox[most:]
        return data

    def wait(self, count: int, seconds: float) -> bytes:
        return self.read(count)

    def put(self, data: bytes) -> None:
        """Bytes that the board never sent."""
        self._inbox += data

    def exchange_done(self) -> None: ...

    def take_over(self) -> None: ...

    def close(self) -> None: ...


BOARDS: dict[str, Callable[[World], Board]] = {"cobs": CobsBoard, "haply": HaplyBoard}


def on_wire(name: str) -> tuple[Device, Wire]:
    """A fresh active device of a serial driver, with permission to push, on a board at rest."""
    return copy.deepcopy(_active(name))


@functools.cache
def _active(name: str) -> tuple[Device, Wire]:
    module = importlib.import_module(f"hil.drivers.{name}.driver")
    file = parse_file({"driver": name})
    region = file.linkage.default_region()
    middle = ((region.left + region.right) / 2, (region.bottom + region.top) / 2)
    angle = file.linkage.angles(middle)
    assert angle is not None
    wire = Wire(BOARDS[name](World(Rest(angle), lockstep=True)))
    kept, module.SerialPort = module.SerialPort, lambda *_: wire
    try:
        device = Device(
            find(name),
            parse(f"{name}://wire?lockstep=1"),
            parse_file({"driver": name, "home": list(angle)}),
            tick=TICK,
            permission=emulated("wire", None),
        )
        device.configure()
    finally:
        module.SerialPort = kept
    device.home()
    for tick in range(-40, 0):
        device.read(tick)
        device.write(tick, ZERO)
    device.activate()
    return device, wire
