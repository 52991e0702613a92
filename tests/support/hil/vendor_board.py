"""A board that a maker's library talks to: motors, encoders and a watchdog in another process.

Time passes when the test says so, one tick a time; what dies with the control loop is the library
and never the board.
"""

from __future__ import annotations

import multiprocessing
from math import pi
from typing import Any

from hil.device.contract import ZERO
from hil.emulation.plant import SimulatedPantograph
from hil.safety.linkage import Pair

PARAMETERS = {"device": 0, "initial_tip_position": (0.0425, 0.2)}


class Board:
    """The pantograph under the torque that the board holds (N.m)."""

    def __init__(self) -> None:
        self.body = SimulatedPantograph(PARAMETERS)
        self.torque: Pair = ZERO
        self.rest: Pair | None = None
        """The torque that the watchdog drives to, ``None`` where nobody configured one."""
        self.limit: int | None = None
        self.silence = 0
        self.expired = False

    def write(self, torque: Pair) -> None:
        self.torque = torque

    def arm(self, ticks: int) -> None:
        """Start the watchdog."""
        self.limit, self.silence, self.expired = ticks, 0, False

    def feed(self) -> bool:
        """Whether it was in time."""
        self.silence = 0
        return not self.expired

    def disarm(self) -> None:
        self.limit = None

    def clear(self) -> None:
        self.expired, self.silence = False, 0

    def tick(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.body.step(self.torque)
            self.silence += 1
            if self.limit is not None and self.silence > self.limit:
                self.expired = True
                self.torque = ZERO if self.rest is None else self.rest

    def count(self, counts_per_turn: int) -> tuple[int, int]:
        first, second = (round(a / (2 * pi) * counts_per_turn) for a in self.body.angle())
        return first, second

    def state(self) -> dict[str, Any]:
        return {"torque": self.torque, "expired": self.expired, "angle": self.body.angle()}

    def protect(self, rest: Pair) -> None:
        """What the watchdog drives the outputs to."""
        self.rest = rest


def _serve(pipe: Any) -> None:
    board = Board()
    while True:
        try:
            name, arguments = pipe.recv()
        except EOFError:
            return
        pipe.send(getattr(board, name)(*arguments))


class RemoteBoard:
    """A board in a process of its own: every method of :class:`Board`, called over a pipe."""

    def __init__(self) -> None:
        context: Any = multiprocessing.get_context("forkserver")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def __getattr__(self, name: str) -> Any:
        def call(*arguments: Any) -> Any:
            self._pipe.send((name, arguments))
            assert self._pipe.poll(60), "the board's process does not answer"
            return self._pipe.recv()

        return call

    def close(self) -> None:
        self._pipe.close()
        self._process.join(10)
        self._process.close()
