"""Two CiA 402 drives in torque mode, a node each, from the profile's state diagram alone.

Their shafts stand where they are. A timer or a heartbeat that runs out is reported and leads out of
Operational; but what is noted is what they were told.
"""

from __future__ import annotations

from tests.support.hil.motors.node import PRE_OPERATIONAL, Key, Node, signed
from tests.support.hil.motors.slcan import Lines
from tests.support.hil.motors.told import Told

NODES = (1, 2)
COUNTS, RATED = 20000, 0.2
"""Increments a turn; rated torque (N.m)."""
DISABLED, READY, ON, ENABLED, FAULT = 0x40, 0x21, 0x23, 0x27, 0x08
COMMANDS_MISSING = 0x8250
OBJECTS = {
    (0x1400, 5): 0,
    (0x6007, 0): 1,
    (0x6040, 0): 0,
    (0x6041, 0): DISABLED,
    **{(index, 0): 2 for index in range(0x605A, 0x605F)},
    **{(index, 0): 0 for index in (0x6060, 0x6061, 0x6064, 0x6071, 0x6074)},
    (0x6076, 0): round(RATED * 1e3),
    (0x6087, 0): 1000,
    (0x608F, 1): COUNTS,
    (0x608F, 2): 1,
    (0x6502, 0): 1 << 9 | 1 << 3,
}
SIZES = dict.fromkeys((0x6007, 0x6040, 0x6041, 0x6071, 0x6074, *range(0x605A, 0x605F)), 2)
SIZES |= dict.fromkeys((0x6060, 0x6061), 1)
STEPS = {
    (DISABLED, 6): READY,
    (READY, 7): ON,
    (ON, 15): ENABLED,
    (ON, 6): READY,
    (ENABLED, 6): READY,
    (ENABLED, 7): ON,
}


class Drive(Node):
    """Torque is the target while the drive is enabled."""

    zeros: set[int]
    """Drives whose demand was read as zero since a torque came; of the whole board."""

    def begin(self) -> None:
        super().begin()
        self.control, self.silence, self.late = 0, 0, False

    def wrote(self, key: Key) -> bool:
        if key == (0x6060, 0):
            self.entries[0x6061, 0] = self.entries[key]
        if key in {(0x1400, 5), (0x6040, 0)}:
            self.silence, self.late = 0, False
        if key == (0x6040, 0):
            self.follow(self.entries[key])
        if self.target():
            self.zeros.clear()
        return key in {(0x6040, 0), (0x6071, 0)}

    def follow(self, control: int) -> None:
        rises, self.control = control & ~self.control, control
        now = self.entries[0x6041, 0]
        if now == FAULT:
            self.entries[0x6041, 0] = DISABLED if rises & 0x80 else FAULT
        elif control & 6 != 6:
            self.entries[0x6041, 0] = DISABLED
        else:
            self.entries[0x6041, 0] = STEPS.get((now, control & 15), now)

    def target(self) -> int:
        if self.entries[0x6041, 0] != ENABLED:
            return 0
        return signed(self.entries[0x6071, 0], 2)

    def sync(self) -> bytes:
        self.entries[0x6074, 0] = self.target()
        return super().sync()

    def serve(self, request: bytes) -> list[Told]:
        self.entries[0x6074, 0] = self.target()
        return super().serve(request)

    def confirms(self, key: Key) -> bool:
        if key != (0x6074, 0) or self.entries[key]:
            return False
        self.zeros.add(self.number)
        return self.zeros == set(NODES)

    def tick(self) -> list[Told]:
        found = super().tick()
        self.silence += 1
        limit = self.entries[0x1400, 5]
        if limit and self.silence > limit and not self.late:
            self.late, self.state = True, PRE_OPERATIONAL
            found.append(self.report(COMMANDS_MISSING))
        return found


class Cia402:
    """Both drives, on one line."""

    def __init__(self) -> None:
        self.lines = Lines()
        self.drives: list[Drive] = []
        zeros: set[int] = set()
        self.drives += [Drive(number, OBJECTS, SIZES, self.torques) for number in NODES]
        for drive in self.drives:
            drive.zeros = zeros

    def feed(self, data: bytes) -> list[Told]:
        found: list[Told] = []
        for identifier, content in self.lines.frames(data):
            if identifier == 0x080 and not content:
                answer = b"".join(drive.sync() for drive in self.drives)
                at_zero = not any(drive.target() for drive in self.drives)
                found.append(Told(answer=answer, zero=bool(answer) and at_zero))
                continue
            for drive in self.drives:
                found += drive.hear(identifier, content)
        return found

    def tick(self) -> list[Told]:
        return [told for drive in self.drives for told in drive.tick()]

    def torques(self) -> tuple[float, ...]:
        if len(self.drives) < len(NODES):
            return ()
        return tuple(drive.target() * 1e-3 * RATED for drive in self.drives)
