"""The SimpleFOC sketch, compiled for this machine, as the board behind the wire."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

from hil.emulation.board import Board, Unit
from hil.emulation.faults import FaultKind

FIRMWARE = Path(__file__).parents[3] / "hil/firmware"
SKETCH = FIRMWARE / "simplefoc/cohaptic_simplefoc.ino"
STUB = Path(__file__).with_name("simplefoc")
COUNTS, TORQUE_CONSTANT = 16384, 0.036
"""As the sketch has them."""


class Cells(ctypes.Structure):
    """``Board`` of the stub."""

    _fields_ = (
        ("micros", ctypes.c_uint32),
        ("angle", ctypes.c_float * 2),
        ("current", ctypes.c_float * 2),
        ("enabled", ctypes.c_int * 2),
        ("incoming", ctypes.c_uint8 * 4096),
        ("outgoing", ctypes.c_uint8 * 4096),
        ("in_size", ctypes.c_int),
        ("in_place", ctypes.c_int),
        ("out_size", ctypes.c_int),
    )


def build_sketch(folder: Path) -> Path:
    """The sketch with what stands for Arduino and SimpleFOC, as a library."""
    library = folder / "sketch.so"
    subprocess.run(
        [
            *(sys.executable, "-m", "ziglang", "cc", "-O2", "-Wall", "-Wextra", "-Werror"),
            *("-fno-exceptions", "-fno-rtti", "-shared", "-fPIC", f'-DSKETCH="{SKETCH}"'),
            *("-I", str(STUB), "-I", str(FIRMWARE), "-o", str(library)),
            *(str(STUB / "board.cpp"), "-x", "c", str(FIRMWARE / "cohaptic_device.c")),
        ],
        check=True,
    )
    return library


class SketchBoard(Board):
    """Bytes and time go in, currents and bytes come out."""

    def __init__(self, world, *, tick: float, library: str) -> None:
        super().__init__(world)
        self._tick, self._time = tick, 0.0
        self._library = ctypes.CDLL(library)
        self._library.sketch_board.restype = ctypes.POINTER(Cells)
        self._cells = self._library.sketch_board().contents
        self._library.sketch_setup()

    def receive(self, unit: Unit) -> list[Unit]:
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        for byte in unit:  # an answer ends a tick, so no more than one at a time
            self._cells.incoming[0], self._cells.in_size, self._cells.in_place = byte, 1, 0
            answer = self._loop()
            if answer:
                answers.append(answer)
                self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        self._time += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._time = 0.0
            self._library.sketch_setup()
        self._loop()
        return []

    def _loop(self) -> bytes:
        cells = self._cells
        cells.micros = round(self._time * 1e6) & 0xFFFFFFFF
        cells.angle[0], cells.angle[1] = self.world.angle()
        self._library.sketch_loop()
        size, cells.out_size = cells.out_size, 0
        current = [cells.current[i] if cells.enabled[i] else 0.0 for i in (0, 1)]
        self.world.torque = (current[0] * TORQUE_CONSTANT, current[1] * TORQUE_CONSTANT)
        return bytes(cells.outgoing[:size])
