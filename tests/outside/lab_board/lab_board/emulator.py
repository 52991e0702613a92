"""Our board as its host sees it: it holds the torque, counts, and drops the torque by itself."""

from __future__ import annotations

from hil.device.contract import ZERO
from hil.emulation.board import Board, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_terminal
from hil.emulation.world import World
from lab_board import protocol as wire

WATCHDOG = 0.020
COUNTS = 16384


class LabBoard(Board):
    """Counts are zero where joint angles are zero."""

    def __init__(self, world: World, tick: float) -> None:
        super().__init__(world)
        self._tick = tick
        self._lines = wire.Lines()
        self._silence = 0.0
        self._fired = self._armed = False

    def receive(self, unit: Unit) -> list[Unit]:
        """Answer every valid command; with the answer a tick ends."""
        assert isinstance(unit, bytes)
        answers: list[Unit] = []
        for data in self._lines.feed(unit):
            found = wire.command(data)
            if found is not None:
                answers.append(self._obey(found))
                self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """The watchdog; a restart forgets everything."""
        self._silence += self._tick
        if self.world.fault(FaultKind.RESTART):
            self._lines, self._fired, self._armed = wire.Lines(), False, False
            self.world.torque = ZERO
        if self._silence > WATCHDOG:
            self._fired |= self._armed
            self._armed, self.world.torque = False, ZERO
        return []

    def _obey(self, found: wire.Command) -> bytes:
        self._silence = 0.0
        if found.kind == wire.CLEAR:
            self._fired = False
        if found.kind != wire.TORQUE:
            self._armed = found.kind == wire.CLEAR
        torque = (found.torque[0] * 1e-6, found.torque[1] * 1e-6)
        self.world.torque = torque if self._armed else ZERO
        status = wire.ENABLED * self._armed | wire.FIRED * self._fired
        status |= wire.ZERO * (self.world.torque == ZERO)
        return wire.line("A", found.sequence, *self.world.count(COUNTS), status)


def make(order: Order, world: World) -> Made:
    """A board on a pseudo-terminal."""
    link = on_terminal(order)
    return LabBoard(world, order.tick), link, f"lab://{link.path}"
