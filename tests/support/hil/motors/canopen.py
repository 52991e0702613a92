"""One CANopen node with two encoders (CiA 406) and two amplifiers on analogue outputs (CiA 401)."""

from __future__ import annotations

from tests.support.hil.motors.node import Key, Node, signed
from tests.support.hil.motors.slcan import Lines
from tests.support.hil.motors.told import Told

NODE = 1
COUNTS = 20000
VOLTS_PER_CODE, TORQUE_PER_VOLT = 10 / 32767, 0.0182
"""Of a DAC for 10 V; of a motor of 36.4 mN.m/A behind an amplifier of 0.5 A/V."""
OUTPUTS = ((0x6411, 1), (0x6411, 2))
OBJECTS = {
    (0x6001, 0): COUNTS,
    (0x6002, 0): COUNTS * 4096,
    **{(index, channel): 0 for index in (0x6010, 0x6020, 0x6411) for channel in (1, 2)},
    **{(index, channel): 0 for index in (0x6443, 0x6444) for channel in (1, 2)},
}


class Module(Node):
    """Both shafts stand where their preset says."""

    def begin(self) -> None:
        super().begin()
        self.zeros: set[Key] = set()
        """Outputs that were read as zero since a torque came."""

    def wrote(self, key: Key) -> bool:
        if key[0] == 0x6010:
            self.entries[0x6020, key[1]] = self.entries[key]
        if key in OUTPUTS and any(self.entries[place] for place in OUTPUTS):
            self.zeros.clear()
        return key in OUTPUTS

    def confirms(self, key: Key) -> bool:
        self.zeros |= {key} if key in OUTPUTS and self.entries[key] == 0 else set()
        done = self.zeros == set(OUTPUTS)
        if done:
            self.zeros.clear()
        return done


class Canopen:
    """The node, at the end of a line."""

    def __init__(self) -> None:
        self.lines = Lines()
        self.node = Module(NODE, OBJECTS, {0x6411: 2, 0x6443: 1}, self.torques)

    def feed(self, data: bytes) -> list[Told]:
        found: list[Told] = []
        for identifier, content in self.lines.frames(data):
            if identifier == 0x080 and not content:
                found.append(Told(answer=self.node.sync()))
            else:
                found += self.node.hear(identifier, content)
        return found

    def tick(self) -> list[Told]:
        return self.node.tick()

    def torques(self) -> tuple[float, ...]:
        codes = [signed(self.node.entries[place], 2) for place in OUTPUTS]
        return tuple(code * VOLTS_PER_CODE * TORQUE_PER_VOLT for code in codes)
