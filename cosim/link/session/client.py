"""The loop's end of the handshake process: starts it, passes datagrams on, hears from it."""

from __future__ import annotations

import contextlib
import json
import select
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

from cosim.base.errors import InputError, RunError
from cosim.link.session.greeting import SIZES
from cosim.link.session.keys import SessionKeys
from cosim.link.session.live import KEEP_SIZE
from cosim.link.session.messages import (
    ARMED,
    DATAGRAM,
    FACTS,
    LARGEST_MESSAGE,
    LIVE,
    NOTE,
    OFFER,
    PATH,
    QUIT,
    REFUSAL,
    START,
    STATUS,
    USE,
    SessionTaker,
)
from cosim.link.session.start import Start
from cosim.link.wire.packet import PacketKind

FORWARDS_AT_ONCE = 64
"""Datagrams that the loop passes on between two looks at the process; what is lost is repeated."""
LAST_WORDS = 2.0
"""Longest time (s) to wait for the counts of the process after the loop."""
PATIENT = 0.05
"""Longest pause (s) between two looks at what the process says, before the start."""


class HandshakeProcess:
    """Sessions and start for the links of one station; a context manager that ends the process."""

    def __init__(self, own: str, peers: Sequence[str]) -> None:
        self.own = own
        self.peers = list(peers)
        self.links: Sequence[SessionTaker] = []
        self.start: Start | None = None
        self.dropped = 0
        """Datagrams not passed on: too many, of a wrong size, or the other process too slow."""
        self.absurd = 0
        """Messages of the process that made no sense."""
        self.sessions = 0
        """Sessions begun, all peers together."""
        self.facts: dict[str, Any] = {}
        """What the process had counted when it was told to end; empty where it did not answer."""
        self._forwarded = 0
        self._process: subprocess.Popen[str] | None = None
        self._own: socket.socket | None = None
        self._waiting = select.poll()
        self._gone = False
        """The process has hung up."""

    def forward(self, number: int) -> Callable[[memoryview, int], None]:
        """What the link to peer ``number`` passes handshake datagrams to."""

        def pass_on(datagram: memoryview, arrived: int) -> None:
            kind, size = datagram[3], len(datagram)
            # What cannot be a greeting must not use up the room of one that is.
            if size != SIZES.get(kind) and (kind, size) != (PacketKind.KEEP, KEEP_SIZE):
                self.dropped += 1
                return
            self._forwarded += 1
            if self._own is None or self._forwarded > FORWARDS_AT_ONCE:
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
        key_files: Sequence[Path | None],
        contracts: Sequence[Mapping[str, Any]],
        addresses: Sequence[str],
        tick: Fraction,
        period: int,
        exchanges: int,
    ) -> None:
        """Start the process; the sockets are shared with it, lists are in the order of the peers.

        ``exchanges`` is how many clock exchanges have to be there before the start.
        """
        kind = getattr(socket, "SOCK_SEQPACKET", socket.SOCK_DGRAM)
        mine, theirs = socket.socketpair(socket.AF_UNIX, kind)
        numbers = [link.fileno() for link in sockets]
        settings: dict[str, Any] = {
            "own": self.own,
            "peers": self.peers,
            "sockets": numbers,
            "loop": theirs.fileno(),
            "key_files": [None if file is None else str(file.absolute()) for file in key_files],
            "contracts": list(contracts),
            "addresses": list(addresses),
            "exchanges": exchanges,
            "tick": str(tick),
            "period": period,
        }
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-m", "cosim.link.session.process"],
            stdin=subprocess.PIPE,
            pass_fds=[*numbers, theirs.fileno()],
            text=True,
            # Ctrl-C reaches the loop, which stops in order; this process follows it.
            start_new_session=True,
        )
        theirs.close()
        self.attach(mine)
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(settings) + "\n")
        self._process.stdin.close()

    def attach(self, own: socket.socket) -> None:
        """Hear and speak through ``own``, one end of a socket pair."""
        own.setblocking(False)
        self._own = own
        self._waiting.register(own.fileno(), select.POLLIN)

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
                raise RunError(
                    f"{', '.join(self.peers)} did not come: is the other station running, with the "
                    "same key, and do --listen and --peer of both sides fit?"
                )
        return self.start

    def go_live(self) -> None:
        """From now on the loop reads the sockets."""
        if self._own is not None:
            # Not to be lost: the other process would go on reading what is the loop's.
            self._own.setblocking(True)
            with contextlib.suppress(OSError):
                self._own.send(LIVE)
            self._own.setblocking(False)

    def hear(self, say: Callable[[str], None] | None = None) -> None:
        """Take what the process has to tell; call it now and then, it never waits.

        Raises:
            InputError: only where ``say`` is given, before the start: a peer runs something else.
        """
        self._forwarded = 0
        while self._own is not None and not self._gone and self._waiting.poll(0):
            try:
                message = self._own.recv(LARGEST_MESSAGE)
            except OSError:
                return
            if not message:
                self._gone = True
                return
            try:
                self._take(message, say)
            except InputError:
                raise
            except (ValueError, LookupError, TypeError, struct.error):
                self.absurd += 1

    def tell(self, epoch: int, alive: Sequence[int]) -> None:
        """Tell where the own grid lies (ns), and of every peer the session that is alive, or 0."""
        if self._own is None:
            return
        try:
            self._own.send(STATUS.pack(b"S", epoch) + struct.pack(f"<{len(alive)}Q", *alive))
        except OSError:
            self.dropped += 1

    def leave(self) -> None:
        """Say that the loop is over: nobody is to be found here any more. Then its counts come."""
        if self._own is None:
            return
        with contextlib.suppress(OSError):
            self._own.send(QUIT)
        end = time.monotonic() + LAST_WORDS
        while not self.facts and not self._gone and time.monotonic() < end:
            self._waiting.poll(10)
            self.hear()

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

    def __enter__(self) -> HandshakeProcess:
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
            raise RunError("the process that shakes hands has ended; its message is above")

    def _take(self, message: bytes, say: Callable[[str], None] | None) -> None:
        match message[:1]:
            case b"O":
                number: int
                _, number, same, session, outgoing, incoming = OFFER.unpack(message)
                self.links[number].offer(SessionKeys(session, outgoing, incoming), same=same)
            case b"U":
                _, number, session = USE.unpack(message)
                self.sessions += self.links[number].use(session)
            case b"A":
                _, number, round_trip, incoming = PATH.unpack(message)
                self.links[number].expect(round_trip, incoming)
            case b"G":
                _, epoch, first_tick = START.unpack(message)
                self.start = Start(epoch, first_tick)
            case _ if message[:1] == NOTE:
                if say is not None:
                    say(message[1:].decode())
            case _ if message[:1] == FACTS:
                self.facts = json.loads(message[1:])
            case _ if message[:1] == REFUSAL:
                self._refuse(json.loads(message[1:]), say)
            case _:
                self.absurd += 1

    def _refuse(self, facts: dict[str, Any], say: Callable[[str], None] | None) -> None:
        if say is None:
            # The loop runs: what a peer says of itself ends nothing.
            return
        if "error" in facts:
            raise InputError(str(facts["error"]))
        peer = str(facts["peer"])
        lines = "\n  ".join(facts["differences"]) or "it does not say how"
        text = f"{peer} runs something else:\n  {lines}"
        # What the answering side hears may be an old recording, so it only says so and goes on.
        if self.own > peer:
            raise InputError(text)
        say(text)
