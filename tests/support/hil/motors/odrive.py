"""Two ODrive axes (CAN Simple): identifier = node << 5 | command, little-endian."""

from __future__ import annotations

import struct

from tests.support.hil.motors.slcan import Lines, line
from tests.support.hil.motors.told import Told

NODES = (0, 1)
HEARTBEAT, SET_STATE, ESTIMATES, SET_TORQUE = 0x01, 0x07, 0x09, 0x0E
IDLE, CLOSED_LOOP = 1, 8
CLEAR_ERRORS, WATCHDOG_EXPIRED = 0x18, 0x01000000
HEARTBEAT_TICKS, WATCHDOG_TICKS = 10, 20


class Odrive:
    """Both shafts stand at zero; an axis out of closed loop gives no torque."""

    def __init__(self) -> None:
        self.lines = Lines()
        self.state = dict.fromkeys(NODES, IDLE)
        self.input = dict.fromkeys(NODES, 0.0)
        self.error = dict.fromkeys(NODES, 0)
        self.silence = dict.fromkeys(NODES, 0)
        self.ticks = 0

    def feed(self, data: bytes) -> list[Told]:
        found = []
        for identifier, content in self.lines.frames(data):
            node, command = identifier >> 5, identifier & 0x1F
            if node not in NODES:
                continue
            self.silence[node] = 0
            if command == CLEAR_ERRORS:
                self.error[node] = 0
            if command not in {SET_STATE, SET_TORQUE}:
                continue
            if command == SET_STATE:
                (self.state[node],) = struct.unpack("<I", content)
            else:
                (self.input[node],) = struct.unpack("<f", content)
            found.append(Told(self.torques()))
        return found

    def tick(self) -> list[Told]:
        self.ticks += 1
        for node in NODES:
            self.silence[node] += 1
            if self.state[node] == CLOSED_LOOP and self.silence[node] > WATCHDOG_TICKS:
                self.state[node], self.error[node] = IDLE, WATCHDOG_EXPIRED
        answer = b"".join(line(node << 5 | ESTIMATES, bytes(8)) for node in NODES)
        found = [Told(answer=answer)]
        if self.ticks % HEARTBEAT_TICKS == 0:
            beats = [
                line(
                    node << 5 | HEARTBEAT,
                    struct.pack("<IBBBB", self.error[node], self.state[node], 0, 0, 0),
                )
                for node in NODES
            ]
            found.append(Told(answer=b"".join(beats), zero=set(self.state.values()) == {IDLE}))
        return found

    def torques(self) -> tuple[float, ...]:
        return tuple(self.input[n] if self.state[n] == CLOSED_LOOP else 0.0 for n in NODES)
