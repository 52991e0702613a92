"""A home-made board: the protocol's device side in Python, or the C reference itself.

With ``firmware``, the path of ``hil/firmware`` compiled as a shared library, every byte goes
through the C code; without, through a second implementation that shares the frame functions only.
"""

from __future__ import annotations

import ctypes
import struct

from hil.device.contract import ZERO
from hil.drivers.cobs.protocol import COMMAND, REPLY, CommandFlag, ReplyFlag
from hil.emulation.board import Board, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_terminal
from hil.emulation.world import World
from hil.wire.cobs_frames import Splitter, frame

LONGEST_WATCHDOG_MS = 100
LARGEST_TORQUE = 10.0
"""A command of as much or more (N.m) is noise, as in the C reference."""


class CobsBoard(Board):
    """Counts are zero where joint angles are zero."""

    def __init__(
        self, world: World, *, counts_per_turn: int = 20000, tick: float = 1 / 1024
    ) -> None:
        super().__init__(world)
        self._counts, self._tick = counts_per_turn, tick
        self._splitter = Splitter()
        self._time = 0.0
        self._last = 0.0
        self._watchdog = 0.0
        self._fired = self._enabled = False

    def receive(self, unit: Unit) -> list[Unit]:
        """Answer every valid command."""
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        for body in self._splitter.feed(unit):
            if len(body) == 14 and body[0] == COMMAND:
                answer = self._command(body)
                if answer is not None:
                    answers.append(answer)
                    self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """The watchdog; after a restart nothing is known of what was commanded before."""
        self._time += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._splitter, self._time, self._last = Splitter(), 0.0, 0.0
            self._fired = self._enabled = False
            self.world.torque = ZERO
        if self._watchdog and self._time - self._last > self._watchdog:
            self._fired |= self._enabled
            self._enabled, self.world.torque = False, ZERO
        return []

    def _command(self, body: bytes) -> bytes | None:
        _, flags, sequence, first, second, watchdog = struct.unpack("<BBHffH", body)
        if not (abs(first) < LARGEST_TORQUE and abs(second) < LARGEST_TORQUE):  # no number, too
            return None
        self._last = self._time
        self._watchdog = min(watchdog or LONGEST_WATCHDOG_MS, LONGEST_WATCHDOG_MS) * 1e-3
        if flags & CommandFlag.CLEAR:
            self._fired = False
        self._enabled = bool(flags & CommandFlag.ENABLE) and not self._fired
        self.world.torque = (first, second) if self._enabled else ZERO
        status = ReplyFlag.ENABLED * self._enabled | ReplyFlag.WATCHDOG_FIRED * self._fired
        status |= ReplyFlag.INPUT * self.world.input
        if self.world.torque == ZERO:
            status |= ReplyFlag.ZERO
        return frame(
            struct.pack(
                "<BBHIiiH",
                REPLY,
                status,
                sequence,
                round(self._time * 1e6) & 0xFFFFFFFF,
                *self.world.count(self._counts),
                0,
            )
        )


class _Device(ctypes.Structure):
    _fields_ = (
        ("torque", ctypes.c_float * 2),
        ("last_command_us", ctypes.c_uint32),
        ("watchdog_ms", ctypes.c_uint16),
        ("fired", ctypes.c_uint8),
        ("enabled", ctypes.c_uint8),
        ("input", ctypes.c_uint8),
        ("overflow", ctypes.c_uint8),
        ("length", ctypes.c_uint8),
        ("pending", ctypes.c_uint8 * 64),
    )


class FirmwareBoard(Board):
    """The C reference, a byte at a time."""

    def __init__(
        self,
        world: World,
        *,
        firmware: str,
        counts_per_turn: int = 20000,
        tick: float = 1 / 1024,
    ) -> None:
        super().__init__(world)
        self._counts, self._tick, self._time = counts_per_turn, tick, 0.0
        self._library = ctypes.CDLL(firmware)
        self._library.device_receive.restype = ctypes.c_size_t
        self._device = _Device()
        self._library.device_init(ctypes.byref(self._device))

    def receive(self, unit: Unit) -> list[Unit]:
        """Feed the bytes."""
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        answer = (ctypes.c_uint8 * 24)()
        for byte in unit:
            self._device.input = self.world.input
            count = (ctypes.c_int32 * 2)(*self.world.count(self._counts))
            size = self._library.device_receive(
                ctypes.byref(self._device),
                ctypes.c_uint8(byte),
                ctypes.c_uint32(self._now()),
                count,
                answer,
            )
            self._drive()
            if size:
                answers.append(bytes(answer)[:size])
                self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """The watchdog."""
        self._time += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._library.device_init(ctypes.byref(self._device))
            self._time = 0.0
        self._library.device_tick(ctypes.byref(self._device), ctypes.c_uint32(self._now()))
        self._drive()
        return []

    def _now(self) -> int:
        return round(self._time * 1e6) & 0xFFFFFFFF

    def _drive(self) -> None:
        self.world.torque = (float(self._device.torque[0]), float(self._device.torque[1]))


def make(order: Order, world: World) -> Made:
    """A board on a pseudo-terminal; with the option ``firmware``, the C reference."""
    link = on_terminal(order)
    kind = FirmwareBoard if "firmware" in order.options else CobsBoard
    return kind(world, tick=order.tick, **order.options), link, f"cobs://{link.path}"
