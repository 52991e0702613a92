"""An emulated force sensor at the handle of a simulated pantograph: it measures the hand."""

from __future__ import annotations

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


def make(order: Order, world: World) -> Made:
    """A sensor on a pseudo-terminal."""
    link, body = on_terminal(order), world.body
    assert isinstance(body, SimulatedPantograph), "an emulator moves a simulated pantograph"
    board = ForceSensorBoard(world, lambda: body.hand_force, tick=order.tick, **order.options)
    return board, link, f"force_sensor://{link.path}"
