"""An emulated force sensor at the handle of a simulated pantograph: it measures the hand."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable

from hil.emulation.board import Board, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_terminal
from hil.emulation.plant import SimulatedPantograph
from hil.emulation.world import World
from hil.safety.linkage import Pair
from hil.wire.cobs_frames import Splitter, frame

MILLINEWTONS, CHANNELS, END = 1e3, 6, 50_000
"""Counts per newton, channels, and the end of a force's range, as the preset ``six_axis`` has."""
BROWN_OUT = 1


class ForceSensorBoard(Board):
    """Six channels; ``hand_force`` gives what the hand does (N)."""

    def __init__(
        self,
        world: World,
        hand_force: Callable[[], Pair],
        *,
        serial: int = 4711,
        tick: float = 1 / 1024,
    ) -> None:
        super().__init__(world)
        self._hand_force, self._serial, self._tick = hand_force, serial, tick
        self._splitter, self._time = Splitter(), 0.0

    def receive(self, unit: Unit) -> list[Unit]:
        """Answer every valid question; whatever else comes means nothing to it."""
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        for body in self._splitter.feed(unit):
            if len(body) != 4 or body[0] not in (2, 3):
                continue
            sequence = int.from_bytes(body[2:], "little")
            answers.append(self._sample(sequence) if body[0] == 2 else self._identity(sequence))
            self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """Its clock goes on; a restart sets it anew."""
        self._time += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._splitter, self._time = Splitter(), 0.0
        return []

    def _identity(self, sequence: int) -> bytes:
        return frame(struct.pack("<BBHHI", 0x83, CHANNELS, sequence, 1, self._serial))

    def _sample(self, sequence: int) -> bytes:
        force = self._hand_force()
        counts = [round(each * MILLINEWTONS) for each in force] + [0] * (CHANNELS - 2)
        if self.world.fault(FaultKind.SATURATE):
            counts[0] = END
        clipped = sum(1 << index for index, count in enumerate(counts) if abs(count) >= END)
        status = BROWN_OUT if self.world.fault(FaultKind.BROWN_OUT) else 0
        microseconds = round(self._time * 1e6) & 0xFFFFFFFF
        return frame(
            struct.pack(
                f"<BBHIBB{CHANNELS}i",
                0x82,
                status,
                sequence,
                microseconds,
                clipped,
                CHANNELS,
                *(max(-END, min(END, count)) for count in counts),
            )
        )


class _Sensor(ctypes.Structure):
    _fields_ = (
        ("counts", ctypes.c_int32 * CHANNELS),
        ("serial", ctypes.c_uint32),
        ("channels", ctypes.c_uint8),
        ("status", ctypes.c_uint8),
        ("clipped", ctypes.c_uint8),
        ("overflow", ctypes.c_uint8),
        ("length", ctypes.c_uint8),
        ("pending", ctypes.c_uint8 * 16),
    )


class FirmwareSensorBoard(Board):
    """The C reference, a byte at a time; ``firmware`` is its library."""

    def __init__(
        self,
        world: World,
        hand_force: Callable[[], Pair],
        *,
        firmware: str,
        serial: int = 4711,
        tick: float = 1 / 1024,
    ) -> None:
        super().__init__(world)
        self._hand_force, self._serial, self._tick = hand_force, serial, tick
        self._library = ctypes.CDLL(firmware)
        self._library.sensor_receive.restype = ctypes.c_size_t
        self._sensor = _Sensor()
        self._begin()

    def _begin(self) -> None:
        self._time = 0.0
        self._library.sensor_init(
            ctypes.byref(self._sensor), ctypes.c_uint8(CHANNELS), ctypes.c_uint32(self._serial)
        )

    def receive(self, unit: Unit) -> list[Unit]:
        """Feed the bytes."""
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        answer = (ctypes.c_uint8 * 40)()
        self._convert()
        for byte in unit:
            size = self._library.sensor_receive(
                ctypes.byref(self._sensor),
                ctypes.c_uint8(byte),
                ctypes.c_uint32(round(self._time * 1e6) & 0xFFFFFFFF),
                answer,
            )
            if size:
                answers.append(bytes(answer)[:size])
                self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """Its clock goes on; a restart sets it anew."""
        self._time += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._begin()
        return []

    def _convert(self) -> None:
        counts = [round(each * MILLINEWTONS) for each in self._hand_force()] + [0] * (CHANNELS - 2)
        if self.world.fault(FaultKind.SATURATE):
            counts[0] = END
        if self.world.fault(FaultKind.BROWN_OUT):
            self._library.sensor_report(ctypes.byref(self._sensor), ctypes.c_uint8(BROWN_OUT))
        self._library.sensor_sample(
            ctypes.byref(self._sensor),
            (ctypes.c_int32 * CHANNELS)(*(max(-END, min(END, count)) for count in counts)),
            (ctypes.c_int32 * CHANNELS)(*[END] * CHANNELS),
        )


def make(order: Order, world: World) -> Made:
    """A sensor on a pseudo-terminal; with the option ``firmware``, the C reference."""
    link, body = on_terminal(order), world.body
    assert isinstance(body, SimulatedPantograph), "an emulator moves a simulated pantograph"
    kind = FirmwareSensorBoard if "firmware" in order.options else ForceSensorBoard
    board = kind(world, lambda: body.hand_force, tick=order.tick, **order.options)
    return board, link, f"force_sensor://{link.path}"
