"""The loop's side of the door: starts the process that shakes hands, and hears from it."""

from __future__ import annotations

import contextlib
import json
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

from cosim.base.errors import InputError, RunError
from cosim.link.session.doorman import (
    ALLOW,
    ARMED,
    DATAGRAM,
    KEYS,
    LIVE,
    NOTE,
    QUIT,
    REFUSAL,
    START,
    STATUS,
)
from cosim.link.session.keys import SessionKeys
from cosim.link.session.meeting import Start
from cosim.link.stream.peer_link import PeerLink

FORWARDS_PER_TICK = 2
"""Datagrams a tick that the loop passes on; the handshake repeats what is lost."""
_LARGEST_MESSAGE = 65_536
PATIENT = 0.05
"""Longest pause (s) between two looks at what the door says, before the start."""


class Door:
    """Sessions and start for the links of one station; a context manager that ends the process."""

    def __init__(self, own: str, peers: Sequence[str]) -> None:
        self.own = own
        self.peers = list(peers)
        self.links: list[PeerLink] = []
        self.start: Start | None = None
        self.dropped = 0
        """Datagrams not passed on: too many, or the other process too slow."""
        self.sessions = 0
        """Sessions begun, all peers together."""
        self._forwarded = 0
        self._process: subprocess.Popen[str] | None = None
        self._own: socket.socket | None = None
        self._waiting = select.poll()
        self._gone = False
        """The process has hung up."""

    def forward(self, number: int) -> Callable[[memoryview, int], None]:
        """What the link to peer ``number`` passes handshake datagrams to."""

        def pass_on(datagram: memoryview, arrived: int) -> None:
            self._forwarded += 1
            if self._own is None or self._forwarded > FORWARDS_PER_TICK:
                self.dropped += 1
                return
            try:
                self._own.send(DATAGRAM.pack(b"D", number, arrived) + bytes(datagram))
            except OSError:
                self.dropped += 1

        return pass_on

    def open(
        self,
        *,
        sockets: Sequence[socket.socket],
        key_file: Path | None,
        contracts: Sequence[Mapping[str, Any]],
        tick: Fraction,
        period: int,
    ) -> None:
        """Start the process; the sockets are shared with it."""
        kind = getattr(socket, "SOCK_SEQPACKET", socket.SOCK_DGRAM)
        mine, theirs = socket.socketpair(socket.AF_UNIX, kind)
        numbers = [link.fileno() for link in sockets]
        settings: dict[str, Any] = {
            "own": self.own,
            "peers": self.peers,
            "sockets": numbers,
            "loop": theirs.fileno(),
            "key_file": None if key_file is None else str(key_file),
            "contracts": list(contracts),
            "tick": str(tick),
            "period": period,
        }
        self._process = subprocess.Popen(
            [sys.executable, "-m", "cosim.link.session.doorman"],
            stdin=subprocess.PIPE,
            pass_fds=[*numbers, theirs.fileno()],
            text=True,
            # Ctrl-C reaches the loop, which stops in order; the door follows it.
            start_new_session=True,
        )
        theirs.close()
        mine.setblocking(False)
        self._own = mine
        self._waiting.register(mine.fileno(), select.POLLIN)
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(settings) + "\n")
        self._process.stdin.close()

    def wait_for_start(
        self,
        *,
        say: Callable[[str], None],
        timeout: float | None,
        meanwhile: Callable[[], float | None] | None = None,
    ) -> Start:
        """Wait until all stations have agreed on a start.

        ``meanwhile`` is called again and again and says how soon (s) it wants to be called next.

        Raises:
            InputError: a peer's contract differs; the sentences say how.
            RunError: nobody came within ``timeout`` (s).
        """
        end = None if timeout is None else time.monotonic() + timeout
        assert self._own is not None
        # Where the other process has refused its settings, its message says why.
        with contextlib.suppress(OSError):
            self._own.send(ARMED)
        known = 0
        say(f"waiting for {', '.join(self.peers)}")
        while self.start is None:
            pause = meanwhile() if meanwhile is not None else None
            select.select([self._own], [], [], PATIENT if pause is None else pause)
            self.hear(say)
            connected = sum(link.session is not None for link in self.links)
            if connected > known:
                known = connected
                say(f"connected to {known} of {len(self.peers)}")
            self._check_alive()
            if end is not None and self.start is None and time.monotonic() > end:
                message = (
                    f"{', '.join(self.peers)} did not come: is the other station running, with the "
                    "same key, and do --listen and --peer of both sides fit?"
                )
                raise RunError(message)
        return self.start

    def go_live(self) -> None:
        """From now on the loop reads the sockets."""
        if self._own is not None:
            self._own.send(LIVE)

    def hear(self, say: Callable[[str], None] | None = None) -> None:
        """Take what the process has to tell; call it now and then, it never waits."""
        self._forwarded = 0
        while self._own is not None and self._waiting.poll(0):
            try:
                message = self._own.recv(_LARGEST_MESSAGE)
            except OSError:
                return
            if not message:
                self._gone = True
                return
            self._take(message, say)

    def tell(self, *, lost: int, tick: int, epoch: int) -> None:
        """Tell where the own grid lies and which peers are lost (a bit for each)."""
        if self._own is None:
            return
        try:
            self._own.send(STATUS.pack(b"S", lost, tick, epoch))
        except OSError:
            self.dropped += 1

    def leave(self) -> None:
        """Say that the loop is over: nobody is to be found here any more."""
        if self._own is not None:
            with contextlib.suppress(OSError):
                self._own.send(QUIT)

    def close(self) -> None:
        """End the process."""
        if self._own is not None:
            with contextlib.suppress(OSError):
                self._own.send(QUIT)
            self._own.close()
            self._own = None
        if self._process is not None:
            try:
                self._process.wait(2.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None

    def __enter__(self) -> Door:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _check_alive(self) -> None:
        if self._gone:
            message = "the process that shakes hands has ended; its message is above"
            raise RunError(message)

    def _take(self, message: bytes, say: Callable[[str], None] | None) -> None:
        match message[:1]:
            case b"K":
                number: int
                _, number, session, outgoing, incoming = KEYS.unpack(message)
                self.links[number].renew(SessionKeys(session, outgoing, incoming, b""))
                self.sessions += 1
            case b"A":
                _, number, round_trip = ALLOW.unpack(message)
                self.links[number].allow(round_trip)
            case b"G":
                _, epoch, first_tick = START.unpack(message)
                self.start = Start(epoch, first_tick)
            case _ if message[:1] == NOTE:
                if say is not None:
                    say(message[1:].decode())
            case _ if message[:1] == REFUSAL:
                self._refuse(json.loads(message[1:]), say)
            case _:
                pass

    def _refuse(self, facts: dict[str, Any], say: Callable[[str], None] | None) -> None:
        if "error" in facts:
            raise InputError(str(facts["error"]))
        peer = str(facts["peer"])
        lines = "\n  ".join(facts["differences"][:40]) or "it does not say how"
        text = f"{peer} runs something else:\n  {lines}"
        if say is None:
            return
        # What the answering side hears may be an old recording, so it only says so and goes on.
        if self.own > peer:
            raise InputError(text)
        say(text)
