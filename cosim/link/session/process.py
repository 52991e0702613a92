"""The handshake process: it holds the keys, shakes hands, and hands sessions to the loop.

The loop's process must not stop for a handshake, and has no use for a pre-shared key. So a child
process does both: before the start it reads the sockets itself; while the loop runs, the loop
passes on what is not a value, and gets new session keys back, through a socket pair. It runs
isolated (``python -I``), so that nothing in the working folder is imported where the keys are; what
it needs comes through standard input.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import struct
import sys
import time
from collections import deque
from typing import Any

from cosim.base.errors import CohapticError
from cosim.link.session.messages import (
    ARMED,
    DATAGRAM,
    FACTS,
    LIVE,
    NOTE,
    QUIT,
    REFUSAL,
    STATUS,
)
from cosim.link.session.negotiator import SessionNegotiator
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, PacketKind
from cosim.link.wire.transport import LARGEST_READ, UdpTransport

STEP = 0.004
"""Longest pause (s) before the process looks at its watch."""
LIVE_STEP = 0.02
"""The same while the loop runs, which then hands on whatever there is to answer."""
READS_PER_STEP = 64
STRANGE = 2
"""Datagrams that fit no key after which that is said."""
MOST_NOTES = 8
"""Sentences about what anybody may have sent, all together."""


class HandshakeServer:
    """The process's sockets around a :class:`SessionNegotiator`."""

    def __init__(self, settings: dict[str, Any]) -> None:
        self.negotiator = SessionNegotiator(settings)
        self.own: str = settings["own"]
        self.peers = self.negotiator.peers
        self.addresses: list[str] = settings.get("addresses", self.peers)
        self.links = [UdpTransport(socket.socket(fileno=number)) for number in settings["sockets"]]
        self.loop = socket.socket(fileno=settings["loop"])
        self.loop.setblocking(False)
        self.live = False
        self.short = self.early_values = self.other_versions = 0
        """Datagrams: too short to be one of the link's, values before the start, of another version
        of the protocol."""
        self._buffer = memoryview(bytearray(LARGEST_READ))
        self._noted: set[str] = set()
        self._version_noted: set[int] = set()
        self._fresh: list[bytes] = []
        self._unsent: deque[bytes] = deque()
        """Messages for a loop that was too busy to take them."""
        self._parent = os.getppid()

    def run(self) -> None:
        """Serve until the loop is gone."""
        while os.getppid() == self._parent:
            sources: list[socket.socket] = [self.loop]
            if not self.live:
                sources += [link.socket for link in self.links]
            ready, _, _ = select.select(sources, [], [], LIVE_STEP if self.live else STEP)
            if self.loop in ready and not self._hear():
                return
            if not self.live:
                for number, link in enumerate(self.links):
                    self._read(number, link)
            self.step(time.monotonic_ns())

    def step(self, now: int) -> None:
        """Send what is due, and tell the loop what is new."""
        due = self.negotiator.agreement.poll(now)
        self._unsent.extend(self.notes())
        self._tell()
        for peer, datagram in due:
            self.links[self.peers.index(peer)].send(datagram)

    def _tell(self) -> None:
        self._unsent.extend(self.negotiator.news())
        while self._unsent:
            try:
                self.loop.send(self._unsent[0])
            except OSError:
                # It is busy, and hears the rest at the next step; or it is gone, which shows there.
                return
            self._unsent.popleft()

    def take(self, number: int, datagram: bytes, arrived: int) -> None:
        """Take a datagram from a peer's address, and answer it where there is an answer."""
        if len(datagram) < HEADER.size:
            self.short += 1
            return
        if datagram[3] == PacketKind.DATA:
            # Values of a peer that is ahead of this side; it repeats them.
            self.early_values += 1
            return
        if datagram[:2] == MAGIC and datagram[2] != VERSION:
            self.other_versions += 1
            self._note_version(number, datagram[2])
            return
        answer = self.negotiator.agreement.receive(
            self.peers[number], datagram, arrived, time.monotonic_ns()
        )
        # The answer may make the peer send under a new session: the own loop hears of that first.
        self._tell()
        if answer is not None:
            self.links[number].send(answer)

    def facts(self) -> dict[str, Any]:
        """What the manifest tells of all that came and changed nothing; never a key."""
        found = self.negotiator.facts()
        for peer, link in zip(self.peers, self.links, strict=True):
            found[peer] |= {"refused": link.refused, "unsent": link.unsent}
        return {
            **found,
            "short": self.short,
            "early_values": self.early_values,
            "other_versions": self.other_versions,
        }

    def notes(self) -> list[bytes]:
        """What to tell who waits, each sentence once."""
        for number, link in enumerate(self.links):
            side = self.negotiator.side(number)
            peer, address = self.peers[number], self.addresses[number]
            if self.live or side.current is not None:
                continue
            if side.drops.same_name >= STRANGE:
                self._note(
                    f"the station at the address of {peer} ({address}) is called {self.own}, too: "
                    "give each station its own --as"
                )
            elif side.drops.foreign >= STRANGE and number not in self._version_noted:
                self._note(
                    f"what comes from the address of {peer} ({address}) does not fit the key: do "
                    "both stations have the same key file, and each its own --as?"
                )
            elif link.refused > 20:
                self._note(
                    f"nothing at the address of {peer} ({address}) takes packets of this station: "
                    "it does not run yet, or expects its peer at another address"
                )
        fresh, self._fresh = self._fresh, []
        return fresh

    def _read(self, number: int, link: UdpTransport) -> None:
        for _ in range(READS_PER_STEP):
            size = link.receive(self._buffer)
            if size < 0:
                return
            self.take(number, bytes(self._buffer[:size]), link.arrival())

    def _note_version(self, number: int, version: int) -> None:
        # Anybody can write a version: of each peer one sentence.
        if number not in self._version_noted and self.negotiator.side(number).current is None:
            self._version_noted.add(number)
            self._note(
                f"{self.peers[number]} speaks version {version} of the link's protocol, and this "
                f"station version {VERSION}: run one version of cohaptic on both"
            )

    def _note(self, sentence: str) -> None:
        if sentence not in self._noted and len(self._noted) < MOST_NOTES:
            self._noted.add(sentence)
            self._fresh.append(NOTE + sentence.encode())

    def _hear(self) -> bool:
        """Take what the loop says; whether to go on."""
        while True:
            try:
                message = self.loop.recv(LARGEST_READ + DATAGRAM.size)
            except BlockingIOError:
                return True
            except OSError:
                return False
            if not message:
                return False
            if message == QUIT:
                with contextlib.suppress(OSError):
                    self.loop.send(FACTS + json.dumps(self.facts()).encode())
                return False
            if message == ARMED:
                self.negotiator.agreement.armed = True
            elif message == LIVE:
                self.live = True
            elif message[:1] == b"D":
                _, number, arrived = DATAGRAM.unpack_from(message)
                self.take(number, message[DATAGRAM.size :], arrived)
            elif message[:1] == b"S":
                _, epoch = STATUS.unpack_from(message)
                self.negotiator.agreement.run_on(epoch)
                alive = struct.unpack_from(f"<{len(self.peers)}Q", message, STATUS.size)
                self.negotiator.hear_of(alive, time.monotonic_ns())


def main() -> None:
    """Read the settings from standard input and serve until the loop is gone."""
    settings: dict[str, Any] = json.loads(sys.stdin.readline())
    try:
        server = HandshakeServer(settings)
    except CohapticError as error:
        loop = socket.socket(fileno=settings["loop"])
        loop.send(REFUSAL + json.dumps({"error": str(error)}).encode())
        return
    with contextlib.suppress(KeyboardInterrupt):
        server.run()


if __name__ == "__main__":
    main()
