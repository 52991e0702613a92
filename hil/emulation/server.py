"""The emulator's process: a board, its link to the host, the side channel, and time.

In lock-step, time passes only when the host's driver says that it has sent everything of a tick; a
board that its host does not reach still ages by one tick then. In real time a clock advances the
mechanism, and answers leave as soon as there is something to answer.
"""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import socket
import struct
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from hil.emulation.board import Board, BoardFrame, Unit
from hil.emulation.faults import Fault, FaultKind
from hil.emulation.links import HostLink
from hil.wire.side_channel import PATIENCE, SYNC

LONGEST_ADVANCE = 10_000
"""Ticks that one request may ask for: a minute's work, and not for ever."""
LONGEST_CATCH_UP = 100
"""Ticks that a real-time emulator makes up for at once after its machine was busy."""


class Server:
    """Runs until told to stop, or until nobody is left to talk to (parent or owner died)."""

    def __init__(
        self,
        board: Board,
        link: HostLink,
        path: Path,
        *,
        tick: float,
        owner: Connection | None = None,
    ) -> None:
        self._board, self._world, self._link = board, board.world, link
        self._tick = tick
        self._unplugged = False
        self._late: list[tuple[int, Unit]] = []
        self._dropped = 0
        self._running = True
        self._parent = os.getppid()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(str(path))
        self._listener.listen(4)
        # The others round a wait up to whole milliseconds, which is more than a tick.
        self._selector = selectors.SelectSelector()
        self._selector.register(self._listener, selectors.EVENT_READ, "listen")
        self._selector.register(link.fileno(), selectors.EVENT_READ, "link")
        if owner is not None:
            self._selector.register(owner, selectors.EVENT_READ, "owner")
        self._in_step: socket.socket | None = None
        """The connection whose host decides when the wire is looked at; before, it always is."""

    def run(self) -> None:
        """Serve."""
        due = time.monotonic() + self._tick
        try:
            while self._running and os.getppid() == self._parent:
                wait = 0.5 if self._world.lockstep else max(0.0, due - time.monotonic())
                ready = self._selector.select(wait)
                if not self._world.lockstep:
                    # First, so that what came is answered from where the mechanism is by now.
                    due = self._pass_time(due)
                for key, _ in ready:
                    self._handle(key)
        finally:
            self._unplug()
            self._listener.close()
            self._selector.close()

    def _pass_time(self, due: float) -> float:
        now = time.monotonic()
        for _ in range(LONGEST_CATCH_UP):
            if now < due:
                return due
            self._advance()
            due += self._tick
        return now + self._tick

    def _handle(self, key: selectors.SelectorKey) -> None:
        if key.data == "listen":
            connection, _ = self._listener.accept()
            self._selector.register(connection, selectors.EVENT_READ, "control")
        elif key.data == "link":
            self._serve_link()
        elif key.data == "owner":
            self._running = False  # it never says anything, so its end was closed
        else:
            assert isinstance(key.fileobj, socket.socket)
            self._serve_control(key.fileobj)

    def _serve_link(self) -> None:
        if self._unplugged:
            return
        for unit in self._link.read():
            if self._world.fault(FaultKind.HANG):
                continue
            taken, tick = self._spoil_command(unit), self._world.tick
            if taken is not None:
                for answer in self._board.receive(taken):
                    self._answer(answer, tick)

    def _spoil_command(self, unit: Unit) -> Unit | None:
        if self._world.fault(FaultKind.DROP_COMMAND) and not self._dropped:
            self._dropped = 1
            return unit[:4] + unit[5:] if isinstance(unit, bytes) else None
        fault = self._world.fault(FaultKind.CORRUPT_COMMAND)
        if fault is None:
            return unit
        return flip(unit, fault.bit) if isinstance(unit, bytes) else None

    def _answer(self, unit: Unit, tick: int) -> None:
        """Send what answers something that came at ``tick``."""
        world = self._world
        lost = world.fault(FaultKind.HANG, tick) or world.fault(FaultKind.DROP, tick)
        if lost or self._unplugged:
            return
        corrupt, delay = world.fault(FaultKind.CORRUPT, tick), world.fault(FaultKind.DELAY, tick)
        if corrupt:
            if isinstance(unit, BoardFrame):
                return  # a bus's own checksum throws it away
            unit = flip(unit, corrupt.bit)
        if delay:
            self._late.append((world.tick + delay.delay, unit))
        else:
            self._deliver(self._late)  # nothing overtakes on a wire
            self._late = []
            self._link.write(unit)

    def _deliver(self, late: list[tuple[int, Unit]]) -> None:
        for _, unit in late:
            self._link.write(unit)

    def _advance(self) -> None:
        self._world.advance()
        self._age()

    def _age(self) -> None:
        """What a tick brings besides the mechanism's motion."""
        for unit in self._board.tick():
            self._answer(unit, self._world.tick)
        due = [each for each in self._late if each[0] <= self._world.tick]
        self._late = [each for each in self._late if each[0] > self._world.tick]
        if not self._unplugged:
            self._deliver(due)
        if self._world.fault(FaultKind.UNPLUG):
            self._unplug()

    def _unplug(self) -> None:
        if not self._unplugged:
            self._unplugged = True
            with contextlib.suppress(KeyError, ValueError, OSError):
                self._selector.unregister(self._link.fileno())
            self._link.close()

    def _serve_control(self, connection: socket.socket) -> None:
        try:
            message = connection.recv(65536)
        except OSError:
            message = b""
        if not message:
            self._selector.unregister(connection)
            self._step_with(None if connection is self._in_step else self._in_step)
            connection.close()
            return
        if message[:1] == SYNC and len(message) == 9:
            self._step_with(connection)
            self._sync(struct.unpack("<q", message[1:])[0])
            answer = struct.pack("<q", self._link.written)
        else:
            answer = json.dumps(self._answer_command(message)).encode()
        with contextlib.suppress(OSError):
            connection.send(answer)

    def _step_with(self, connection: socket.socket | None) -> None:
        if not self._unplugged and (connection is None) != (self._in_step is None):
            if connection is None:
                self._selector.register(self._link.fileno(), selectors.EVENT_READ, "link")
            else:
                self._selector.unregister(self._link.fileno())
        self._in_step = connection

    def _sync(self, sent: int) -> None:
        """Deal with everything up to ``sent``, then let the rest of the tick pass."""
        before, end, late = self._world.tick, time.monotonic() + PATIENCE / 2, False
        self._serve_link()
        while self._link.received < sent and not self._unplugged and not late:
            late = time.monotonic() > end
            time.sleep(0)
            self._serve_link()
        if self._world.tick == before:
            self._world.advance()
        for _ in range(self._world.tick - before):
            self._age()

    def _answer_command(self, message: bytes) -> dict[str, Any]:
        """The answer to a request; an emulator goes on whatever it is asked."""
        try:
            request: Any = json.loads(message)
            return self._command(request)
        except Exception as error:
            return {"error": f"what was asked makes no sense: {error!r}"}

    def _command(self, request: dict[str, Any]) -> dict[str, Any]:
        world = self._world
        match request.pop("do"):
            case "shift":
                world.shift = (float(request["by"][0]), float(request["by"][1]))
            case "input":
                world.input = bool(request["closed"])
            case "start":
                world.body.start()
            case "fault":
                kind = FaultKind(request.pop("kind"))
                start = world.tick + int(request.pop("start", 0))
                world.faults.append(Fault(kind=kind, start=start, **request))
            case "advance":
                for _ in range(min(int(request["ticks"]), LONGEST_ADVANCE)):
                    self._advance()
            case "state":
                if self._in_step is None:
                    self._serve_link()
                return {
                    "received": self._link.received,
                    "written": self._link.written,
                    "tick": world.tick,
                    "torque": world.torque,
                    "applied": world.applied,
                    "largest": world.largest,
                    "angle": world.body.angle(),
                }
            case "stop":
                self._running = False
            case other:
                return {"error": f"unknown request '{other}'"}
        return {}


def flip(data: bytes, bit: int) -> bytes:
    """``data`` with one bit flipped."""
    spoiled = bytearray(data)
    spoiled[bit // 8 % len(spoiled)] ^= 1 << (bit % 8)
    return bytes(spoiled)
