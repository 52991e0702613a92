"""Boards that break one rule of the conformance suite each, behind the framed protocol."""

from __future__ import annotations

import struct
from contextlib import AbstractContextManager
from types import SimpleNamespace

from hil.drivers.cobs.emulator import CobsBoard
from hil.emulation.faults import FaultKind
from hil.wire import cobs_frames
from tests.support.hil.board_process import board_process

REPLY = struct.Struct("<BBHIiiH")
ENABLED, FIRED, IS_ZERO, INPUT = 1, 2, 4, 16


class Mutant(CobsBoard):
    """Answers pass through ``change``: (status, sequence, time in us, counts), or ``None``."""

    def __init__(self, world, **options) -> None:
        super().__init__(world, **options)
        self.answered = 0

    def _command(self, body: bytes) -> bytes | None:
        answer = super()._command(body)
        if answer is None:
            return None
        self.answered += 1
        _, status, sequence, time, *count, age = REPLY.unpack(cobs_frames.payload(answer[:-1]))
        changed = self.change(status, sequence, time, count)
        if changed is None:
            return None
        status, sequence, time, count = changed
        return cobs_frames.frame(REPLY.pack(0x81, status, sequence, time & 0xFFFFFFFF, *count, age))

    def change(self, status, sequence, time, count):
        return status, sequence, time, count


class OpensOnce(Mutant):
    """Says nothing more once its host has begun a second time."""

    openings = 0

    def change(self, status, sequence, time, count):
        self.openings += sequence == 1
        return (status, sequence, time, count) if self.openings < 2 else None


class NeverAtZero(Mutant):
    def change(self, status, sequence, time, count):
        return status & ~IS_ZERO, sequence, time, count


class LosesSamples(Mutant):
    def change(self, status, sequence, time, count):
        return None if self.answered % 50 == 0 else (status, sequence, time, count)


class SlowClock(Mutant):
    def change(self, status, sequence, time, count):
        return status, sequence, time // 2, count


class CountsBackwards(Mutant):
    def change(self, status, sequence, time, count):
        return status, sequence, time, [count[0], -count[1]]


class CountsHalf(Mutant):
    def change(self, status, sequence, time, count):
        return status, sequence, time, [count[0] // 2, count[1]]


class AnswersLate(Mutant):
    """What it says of the joints is a tick older than it could be."""

    before = None

    def change(self, status, sequence, time, count):
        shown, self.before = self.before or count, count
        return status, sequence, time, shown


class SwitchJammed(Mutant):
    def change(self, status, sequence, time, count):
        return status | INPUT, sequence, time, count


class NeverEnabled(Mutant):
    def change(self, status, sequence, time, count):
        return status & ~ENABLED, sequence, time, count


class PushesTwice(Mutant):
    def _command(self, body):
        answer = super()._command(body)
        self.world.torque = (2 * self.world.torque[0], 2 * self.world.torque[1])
        return answer


class TakesAnyNumber(Mutant):
    """What is no number is the largest torque."""

    def _command(self, body):
        kind, flags, sequence, *torque, watchdog = struct.unpack("<BBHffH", body)
        torque = [value if abs(value) < 10 else 0.1 for value in torque]
        return super()._command(struct.pack("<BBHffH", kind, flags, sequence, *torque, watchdog))


class WatchdogSleeps(Mutant):
    def tick(self):
        self._last = self._time
        return super().tick()


class WatchdogHasty(Mutant):
    """Fires after a quarter of its timeout."""

    def tick(self):
        watchdog, self._watchdog = self._watchdog, self._watchdog / 4
        super().tick()
        self._watchdog = watchdog
        return []


class RearmsItself(Mutant):
    def _command(self, body):
        self._fired = False
        return super()._command(body)


class HidesItsReset(Mutant):
    """Comes back as it was, as if nothing had been."""

    def tick(self):
        self.world.faults = [f for f in self.world.faults if f.kind is not FaultKind.RESTART]
        return super().tick()


class IgnoresTheChecksum(Mutant):
    def receive(self, unit):
        answers = []
        *whole, self.rest = (getattr(self, "rest", b"") + unit).split(b"\0")
        for part in whole:
            body = cobs_frames.unstuff(part)
            if body is None or len(body) != 16:
                continue
            answer = self._command(b"\1" + body[1:14])
            if answer is not None:
                answers.append(answer)
                self.world.boundary()
        return answers


class AnswersHalves(Mutant):
    """Takes a command as soon as its torques are there."""

    def receive(self, unit):
        answers = super().receive(unit)
        if not answers and len(unit) > 14:
            answer = self._command(struct.pack("<BBHffH", 1, 2, self.last(unit), 0.0, 0.0, 20))
            answers = [answer] if answer else []
        return answers

    @staticmethod
    def last(unit) -> int:
        body = cobs_frames.unstuff(unit) or b"\0" * 4
        return int.from_bytes(body[2:4], "little")


class ChokesOnJunk(Mutant):
    """A buffer that is never emptied."""

    taken = 0
    choked = False

    def receive(self, unit):
        self.taken = 0 if unit.endswith(b"\0") and len(unit) < 64 else self.taken + len(unit)
        self.choked |= self.taken > 64
        return [] if self.choked else super().receive(unit)


MUTANTS = {
    "opens": OpensOnce,
    "zero": NeverAtZero,
    "samples": LosesSamples,
    "clock": SlowClock,
    "angle": CountsBackwards,
    "angle (scale)": CountsHalf,
    "latency": AnswersLate,
    "switch": SwitchJammed,
    "enabled": NeverEnabled,
    "torque": PushesTwice,
    "nan": TakesAnyNumber,
    "watchdog": WatchdogSleeps,
    "watchdog (early)": WatchdogHasty,
    "rearm": RearmsItself,
    "reset": HidesItsReset,
    "bits": IgnoresTheChecksum,
    "cuts": AnswersHalves,
    "junk": ChokesOnJunk,
}
"""By the rule that each breaks."""


def mutant(name: str) -> AbstractContextManager[SimpleNamespace]:
    """A mutant in a process of its own."""
    return board_process(MUTANTS[name])
