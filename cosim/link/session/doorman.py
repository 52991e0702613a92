"""The process at the door: it holds the key, shakes hands, and hands sessions to the loop.

The loop's process must not stop for a handshake, and has no use for the pre-shared key. So a child
process does both: before the start it reads the sockets itself; while the loop runs, the loop
passes on what is not a value, and gets new session keys back, through a socket pair. Started with
``python -m cosim.link.session.doorman``; what it needs comes through standard input.
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
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.errors import CohapticError
from cosim.link.session.contract import Contract
from cosim.link.session.handshake import Handshake
from cosim.link.session.keys import NO_KEY, read_key_file
from cosim.link.session.meeting import SYNC_EXCHANGES, Meeting
from cosim.link.wire.packet import MAGIC, VERSION
from cosim.link.wire.transport import LARGEST_READ, UdpTransport

# Loop to door.
DATAGRAM = struct.Struct("<cBq")
"""b"D", peer, arrival (ns); the datagram follows."""
STATUS = struct.Struct("<cBqq")
"""b"S", bit per lost peer, session tick, epoch (ns)."""
ARMED = b"Y"
LIVE = b"L"
QUIT = b"Q"
# Door to loop.
KEYS = struct.Struct("<cBQ32s32s")
"""b"K", peer, session, outgoing, incoming key."""
ALLOW = struct.Struct("<cBq")
"""b"A", peer, lowest round trip (ns)."""
START = struct.Struct("<cxqq")
"""b"G", epoch (ns, own clock), first tick."""
REFUSAL = b"R"
"""Followed by JSON: peer, differences."""
NOTE = b"N"
"""Followed by a sentence for who waits; nothing acts on it, for anybody may have caused it."""

STEP = 0.004
"""Longest pause (s) before the door looks at its watch."""
LIVE_STEP = 0.05
"""The same while the loop runs, which then hands on whatever there is to answer."""
ASK_AGAIN = 1_000_000_000
"""ns between two attempts to find a lost peer."""


class Doorman:
    """The state behind the door, without sockets: fed with bytes and times."""

    def __init__(self, settings: dict[str, Any]) -> None:
        self.peers: list[str] = settings["peers"]
        key_file = settings["key_file"]
        key = NO_KEY if key_file is None else read_key_file(Path(key_file))
        self.handshakes = {
            peer: Handshake(own=settings["own"], peer=peer, key=key, contract=Contract(contract))
            for peer, contract in zip(self.peers, settings["contracts"], strict=True)
        }
        self.meeting = Meeting(
            own=settings["own"],
            handshakes=self.handshakes,
            tick=Fraction(settings["tick"]),
            period=settings["period"],
        )
        self.meeting.armed = False
        self._told: dict[str, int] = {}
        self._allowed: dict[str, int] = {}
        self._refused: set[str] = set()
        self._started = False
        self._asked = 0

    def news(self) -> list[bytes]:
        """Messages for the loop about what has changed."""
        out: list[bytes] = []
        for number, peer in enumerate(self.peers):
            keys = self.meeting.sessions().get(peer)
            if keys is not None and self._told.get(peer) != keys.session:
                self._told[peer] = keys.session
                out.append(KEYS.pack(b"K", number, keys.session, keys.outgoing, keys.incoming))
            clock = self.meeting.clock(peer)
            known = keys is not None and clock.ready and clock.samples >= SYNC_EXCHANGES
            if keys is not None and known and self._allowed.get(peer) != keys.session:
                self._allowed[peer] = keys.session
                out.append(ALLOW.pack(b"A", number, clock.round_trip))
            refusal = self.handshakes[peer].refusal
            if refusal is not None and peer not in self._refused:
                self._refused.add(peer)
                text = json.dumps({"peer": peer, "differences": refusal.differences})
                out.append(REFUSAL + text.encode()[:60_000])
        start = self.meeting.start
        if start is not None and not self._started:
            self._started = True
            out.append(START.pack(b"G", start.epoch, start.first_tick))
        return out

    def take_status(self, lost: int, epoch: int, now: int) -> None:
        """The loop runs, with its grid at ``epoch``; look for the peers whose bits are set."""
        self.meeting.run_on(epoch)
        if now - self._asked < ASK_AGAIN:
            return
        for number, peer in enumerate(self.peers):
            if lost >> number & 1:
                self._asked = now
                self.handshakes[peer].ask_again()


class _Process:
    def __init__(self, settings: dict[str, Any]) -> None:
        self.doorman = Doorman(settings)
        self.links = [UdpTransport(socket.socket(fileno=number)) for number in settings["sockets"]]
        self.loop = socket.socket(fileno=settings["loop"])
        self.loop.setblocking(False)
        self.buffer = memoryview(bytearray(LARGEST_READ))
        self.live = False
        self.strange = [0] * len(self.links)
        """Datagrams from each peer's address that its handshake could not use."""
        self.noted: set[str] = set()
        self.fresh: list[bytes] = []
        self.parent = os.getppid()

    def run(self) -> None:
        peers = self.doorman.peers
        while os.getppid() == self.parent:
            sources: list[socket.socket] = [self.loop]
            if not self.live:
                sources += [link.socket for link in self.links]
            ready, _, _ = select.select(sources, [], [], LIVE_STEP if self.live else STEP)
            if self.loop in ready and not self._hear():
                return
            if not self.live:
                for number, link in enumerate(self.links):
                    self._read(number, link)
            for peer, datagram in self.doorman.meeting.poll(time.monotonic_ns()):
                self.links[peers.index(peer)].send(datagram)
            for message in (*self.doorman.news(), *self._notes()):
                # The loop may be busy; it asks often, and its buffer holds hundreds of these.
                with contextlib.suppress(BlockingIOError):
                    self.loop.send(message)

    def _read(self, number: int, link: UdpTransport) -> None:
        for _ in range(64):
            size = link.receive(self.buffer)
            if size < 0:
                return
            self._pass(number, bytes(self.buffer[:size]), link.arrival())

    def _pass(self, number: int, datagram: bytes, arrived: int) -> None:
        if len(datagram) < 24:
            return
        peer = self.doorman.peers[number]
        if datagram[:2] == MAGIC and datagram[2] != VERSION:
            self._note(
                f"{peer} speaks version {datagram[2]} of the link's protocol, and this station "
                f"version {VERSION}: run one version of cohaptic on both"
            )
        handshake = self.doorman.handshakes[peer]
        before = handshake.dropped
        answer = self.doorman.meeting.receive(peer, datagram, arrived, time.monotonic_ns())
        self.strange[number] += handshake.dropped - before
        if answer is not None:
            self.links[number].send(answer)

    def _notes(self) -> list[bytes]:
        """What to tell who waits, each sentence once."""
        for number, (peer, link) in enumerate(zip(self.doorman.peers, self.links, strict=True)):
            if self.live or self.doorman.handshakes[peer].session is not None:
                continue
            if link.refused > 20:
                self._note(f"nothing listens at the address of {peer} so far")
            if self.strange[number] > 3 and not any("version" in said for said in self.noted):
                self._note(
                    f"what comes from the address of {peer} does not fit the key: do both stations "
                    "have the same key file, and each its own --as?"
                )
        fresh, self.fresh = self.fresh, []
        return fresh

    def _note(self, sentence: str) -> None:
        if sentence not in self.noted:
            self.noted.add(sentence)
            self.fresh.append(NOTE + sentence.encode())

    def _hear(self) -> bool:
        """Take what the loop says; whether to go on."""
        while True:
            try:
                message = self.loop.recv(LARGEST_READ + DATAGRAM.size)
            except BlockingIOError:
                return True
            except OSError:
                return False
            if not message or message == QUIT:
                return False
            if message == ARMED:
                self.doorman.meeting.armed = True
            elif message == LIVE:
                self.live = True
            elif message[:1] == b"D":
                _, number, arrived = DATAGRAM.unpack_from(message)
                self._pass(number, message[DATAGRAM.size :], arrived)
            elif message[:1] == b"S":
                _, lost, _, epoch = STATUS.unpack(message)
                self.doorman.take_status(lost, epoch, time.monotonic_ns())


def main() -> None:
    """Read the settings from standard input and serve until the loop is gone."""
    settings: dict[str, Any] = json.loads(sys.stdin.readline())
    try:
        process = _Process(settings)
    except CohapticError as error:
        loop = socket.socket(fileno=settings["loop"])
        loop.send(REFUSAL + json.dumps({"error": str(error)}).encode())
        return
    with contextlib.suppress(KeyboardInterrupt):
        process.run()


if __name__ == "__main__":
    main()
