"""In real time an emulator's mechanism moves every tick, and is asked where it is by then."""

from __future__ import annotations

import itertools
import socket
import time
from types import SimpleNamespace

from hil.emulation import server as served
from hil.emulation.server import Server

WAITS = 50


class World:
    """Counts its ticks, and when they were."""

    lockstep, faults = False, ()

    def __init__(self) -> None:
        self.tick = 0
        self.times: list[float] = []

    def advance(self) -> None:
        self.tick += 1
        self.times.append(time.monotonic())

    def fault(self, kind, tick=None) -> None:
        del kind, tick


class Board:
    """Answers with the number of its tick."""

    def __init__(self) -> None:
        self.world = World()

    def receive(self, unit: bytes) -> list[bytes]:
        del unit
        return [bytes([self.world.tick])]

    def tick(self) -> list[bytes]:
        return []


class Link:
    """One end of a pair of sockets; the test has the other."""

    received = written = 0

    def __init__(self) -> None:
        self.host, self._own = socket.socketpair()

    def fileno(self) -> int:
        return self._own.fileno()

    def read(self) -> list[bytes]:
        return [self._own.recv(64)]

    def write(self, unit: bytes) -> None:
        self._own.send(unit)

    def close(self) -> None:
        self._own.close()


def test_what_came_is_answered_after_the_ticks_that_passed_before(tmp_path, monkeypatch) -> None:
    link, board = Link(), Board()
    link.host.send(b"?")
    clock = itertools.chain([0.0, 0.0], itertools.repeat(5.5))
    monkeypatch.setattr(served, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    server = Server(board, link, tmp_path / "control", tick=1.0)
    monkeypatch.setattr(link, "read", lambda: [setattr(server, "_running", False) or b"?"])
    server.run()
    assert link.host.recv(64) == bytes([5])
    link.host.close()


def test_a_wait_for_the_next_tick_is_not_rounded_to_milliseconds(tmp_path, monkeypatch) -> None:
    """Where a wait of 0.2 ms takes 1 ms or more, ticks of 1 ms come late and in bunches."""
    link, board = Link(), Board()
    server = Server(board, link, tmp_path / "control", tick=2e-4)
    waits: list[float] = []

    def passed(due: float) -> float:
        now = time.monotonic()
        waits.append(now - due + server._tick)
        server._running = len(waits) < WAITS
        return now + server._tick

    monkeypatch.setattr(server, "_pass_time", passed)
    server.run()
    link.host.close()
    assert min(waits) >= 2e-4
    assert min(waits) < 6e-4
