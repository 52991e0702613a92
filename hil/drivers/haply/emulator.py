"""The firmware of a Haply 2DIY board as its hosts see it; it trusts every byte it gets."""

from __future__ import annotations

import struct
from math import degrees, isfinite, pi

from hil.device.contract import ZERO
from hil.drivers.haply.protocol import IO, PORTS, RESET, SETUP
from hil.emulation.board import Board, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_terminal
from hil.emulation.world import World
from hil.safety.linkage import Pair

SATURATION = 0.123
"""The largest torque that the board gives (N.m)."""
WIRING = (2, 1)
"""The ports that the joints' motors are plugged into."""


class HaplyBoard(Board):
    """Ports 1 to 4 with motor and encoder; joint 1 is on port 2, joint 2 on port 1."""

    def __init__(self, world: World, wiring: tuple[int, int] = WIRING) -> None:
        super().__init__(world)
        self._wiring = wiring
        self._pending = b""
        self._motors: list[int] = []
        self._encoders: dict[int, tuple[float, float, Pair]] = {}
        """Port -> offset (degrees), counts per turn, joint angles at setup."""

    def receive(self, unit: Unit) -> list[Unit]:
        """Consume bytes; an answer comes to I/O frames only."""
        assert isinstance(unit, bytes)
        self._pending += unit
        answers: list[Unit] = []
        while len(self._pending) >= 2:
            kind, device = self._pending[0], self._pending[1]
            if kind == RESET:
                self._motors, self._encoders = [], {}
                self._pending = self._pending[2:]
            elif kind == SETUP:
                if not self._set_up():
                    break
            elif kind == IO:
                size = 2 + 4 * len(self._motors)
                if len(self._pending) < size:
                    break
                self._torques(self._pending[2:size])
                self._pending = self._pending[size:]
                answers.append(self._answer(device))
                self.world.boundary()
            else:
                self._pending = self._pending[1:]
        return answers

    def tick(self) -> list[Unit]:
        """A restart forgets the setup; the motors are off until there is a new one."""
        if self.world.fault(FaultKind.RESTART):
            self._pending, self._motors, self._encoders = b"", [], {}
            self.world.torque = ZERO
        return []

    def _set_up(self) -> bool:
        """Take a whole setup frame off the pending bytes; whether it was whole."""
        data = self._pending
        place = 2
        ports: list[list[int]] = []
        for _ in range(2):
            if len(data) <= place:
                return False
            used = [port for port in range(1, PORTS + 1) if data[place] >> (port - 1) & 1]
            ports.append(used)
            place += 1 + len(used)
        for _ in range(2):
            if len(data) <= place:
                return False
            place += 1 + data[place]
        size = place + 8 * len(ports[1])
        if len(data) < size:
            return False
        self._motors, self._encoders = ports[0], {}
        for index, port in enumerate(ports[1]):
            offset, counts = struct.unpack_from("<ff", data, place + 8 * index)
            self._encoders[port] = (offset, counts, self.world.angle())
        self._pending = data[size:]
        return True

    def _torques(self, data: bytes) -> None:
        values = struct.unpack(f"<{len(self._motors)}f", data)
        torque = list(self.world.torque)
        for port, value in zip(self._motors, values, strict=True):
            if port in self._wiring:
                # The board compares, it does not check: what is no number comes out as the limit.
                torque[self._wiring.index(port)] = max(-SATURATION, min(SATURATION, value))
        self.world.torque = (torque[0], torque[1])

    def _answer(self, device: int) -> bytes:
        angles: list[float] = []
        for port in sorted(self._encoders):
            offset, counts, start = self._encoders[port]
            turned = 0.0
            if port in self._wiring:
                joint = self._wiring.index(port)
                now = self.world.angle()[joint]
                quantum = 2 * pi / counts if counts and isfinite(counts) else 0.0
                if quantum:
                    turned = (round(now / quantum) - round(start[joint] / quantum)) * quantum
            angles.append(offset + degrees(turned))
        return struct.pack(f"<B{len(angles)}f", device, *angles)


def make(order: Order, world: World) -> Made:
    """A board on a pseudo-terminal."""
    link = on_terminal(order)
    return HaplyBoard(world), link, f"haply://{link.path}"
