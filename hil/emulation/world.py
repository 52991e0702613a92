"""What is behind an emulated board: the mechanism, its motors, and their faults."""

from __future__ import annotations

from math import pi

from hil.device.contract import ZERO
from hil.emulation.faults import Fault, FaultKind
from hil.emulation.plant import Body
from hil.safety.linkage import Pair

RUNAWAY_TORQUE = 0.2
"""What a motor gives when its driver runs away (N.m)."""


class World:
    """The mechanism under a board's torque.

    In lock-step the board advances it at its protocol's tick boundary; in real time a clock does,
    and the board's ``boundary`` changes nothing.
    """

    def __init__(self, body: Body, *, lockstep: bool) -> None:
        self.body = body
        self.lockstep = lockstep
        self.tick = 0
        self.torque: Pair = ZERO
        """What the board commands."""
        self.applied: Pair = ZERO
        """What the motors really did in the last tick."""
        self.largest = 0.0
        """The largest torque of a motor so far (N.m)."""
        self.input = False
        """Whether the switch on the board is closed."""
        self.shift: Pair = ZERO
        self.faults: list[Fault] = []
        self._latched: Pair | None = None

    def angle(self) -> Pair:
        """Joint angles (rad) as the encoders see them, with the shift of a proof."""
        angle = self.body.angle()
        return angle[0] + self.shift[0], angle[1] + self.shift[1]

    def count(self, counts_per_turn: int) -> tuple[int, int]:
        """Encoder counts, zero at joint angle zero."""
        angle, per = self.angle(), counts_per_turn / (2 * pi)
        return round(angle[0] * per), round(angle[1] * per)

    def boundary(self) -> None:
        """The board has seen a tick's torque."""
        if self.lockstep:
            self.advance()

    def advance(self) -> None:
        """One tick passes under the present torque."""
        self.applied = self._motors()
        self.largest = max(self.largest, abs(self.applied[0]), abs(self.applied[1]))
        self.body.step(self.applied)
        self.tick += 1

    def fault(self, kind: FaultKind, tick: int | None = None) -> Fault | None:
        """The fault of a kind that is active at a tick (now), or ``None``."""
        for fault in self.faults:
            if fault.kind is kind and fault.active(self.tick if tick is None else tick):
                return fault
        return None

    def _motors(self) -> Pair:
        if self.fault(FaultKind.RUNAWAY):
            return RUNAWAY_TORQUE, -RUNAWAY_TORQUE
        if self.fault(FaultKind.LATCHED):
            self._latched = self._latched or self.applied
            return self._latched
        self._latched = None
        return self.torque
