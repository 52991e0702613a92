"""The packets of a measurement, and the side that relays them back.

It is a blocking relay with kernel receive timestamps, not a loop: it measures the network and not
the age that a loop adds. Authentication is the link's own; a reply is as long as its question, and
rate and duration are capped, so that nobody can use it to flood somebody else.
"""

from __future__ import annotations

import contextlib
import select
import socket
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass

from cosim.link.session.contract import Contract
from cosim.link.session.handshake import MESSAGE_SIZE, Handshake
from cosim.link.session.keys import PreSharedKey
from cosim.link.stream.receiver import WINDOW, WINDOW_MASK
from cosim.link.wire.packet import HEADER, MAGIC, TAG_SIZE, VERSION, Kind, Opener, Sealer
from cosim.link.wire.transport import LARGEST_READ, UdpTransport

SERVER, CLIENT = "relay", "source"
CONTRACT = Contract({"netchar": 1})
PROBE = struct.Struct("<q")
"""sent (ns, client's clock)."""
ECHO = struct.Struct("<qqqQ")
"""sent (from the probe), received, relayed (ns, server's clock), probes received so far."""
OVERHEAD = HEADER.size + TAG_SIZE
SMALLEST = OVERHEAD + ECHO.size
LARGEST = 1232
_IDLE = 2_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Caps:
    """What the relay does at most for one measurement."""

    rate: float = 20_000.0
    """Packets a second."""
    duration: float = 3600.0
    """Seconds."""


class Relay:
    """Answers one measurement at a time; give it datagrams, it gives answers."""

    def __init__(self, key: PreSharedKey, caps: Caps) -> None:
        self.caps = caps
        self.capped = 0
        """Probes not answered because of the caps."""
        self.dropped = 0
        """Datagrams that were not authentic, or no probe of the present session."""
        self.received = 0
        self._handshake = Handshake(own=SERVER, peer=CLIENT, key=key, contract=CONTRACT)
        self._address: tuple[object, ...] | None = None
        self._opener: Opener | None = None
        self._sealer: Sealer | None = None
        self._plain = memoryview(bytearray(LARGEST))
        self._answer = memoryview(bytearray(LARGEST))
        self._highest = -1
        self._seen = 0
        self._since = 0
        self._last = 0
        self._allowance = 0.0

    def take(
        self, datagram: memoryview, sender: tuple[object, ...], arrived: int, now: Callable[[], int]
    ) -> memoryview | bytes | None:
        """What to send back to ``sender``, if anything."""
        size = len(datagram)
        if size == MESSAGE_SIZE and datagram[3] != Kind.PROBE:
            return self._shake_hands(bytes(datagram), sender, now())
        if not SMALLEST <= size <= LARGEST or sender != self._address or self._opener is None:
            self.dropped += 1
            return None
        magic, version, kind, stream, zero, session, sequence = HEADER.unpack_from(datagram)
        expected = (MAGIC, VERSION, Kind.PROBE, 0, 0, self._opener.session)
        plain = self._plain[: size - OVERHEAD]
        authentic = (magic, version, kind, stream, zero, session) == expected and self._opener.open(
            datagram, plain
        )
        # A copy made on the way here is not relayed: nobody multiplies packets through a relay.
        if not authentic or not self._is_first(sequence):
            self.dropped += 1
            return None
        if not self._within_caps(arrived):
            self.capped += 1
            return None
        self.received += 1
        (sent,) = PROBE.unpack_from(plain)
        ECHO.pack_into(plain, 0, sent, arrived, now(), self.received)
        answer = self._answer[:size]
        assert self._sealer is not None
        self._sealer.seal(Kind.ECHO, 0, plain, answer)
        return answer

    def _shake_hands(self, datagram: bytes, sender: tuple[object, ...], now: int) -> bytes | None:
        busy = self._address not in {None, sender} and now - self._last < _IDLE
        if busy:
            self.dropped += 1
            return None
        before = self._handshake.session
        answer = self._handshake.receive(datagram, now)
        session = self._handshake.session
        if session is not None and session is not before:
            self._address = sender
            self._opener = Opener(session.incoming, session.session)
            self._sealer = Sealer(session.outgoing, session.session)
            self._highest, self._seen, self.received = -1, 0, 0
            self._since = self._last = now
            self._allowance = self._burst
        return answer

    @property
    def _burst(self) -> float:
        return max(32.0, self.caps.rate * 0.05)

    def _is_first(self, sequence: int) -> bool:
        ahead = sequence - self._highest
        if ahead > 0:
            self._seen = ((self._seen << ahead) | 1) & WINDOW_MASK if ahead < WINDOW else 1
            self._highest = sequence
            return True
        if -ahead >= WINDOW or self._seen & (1 << -ahead):
            return False
        self._seen |= 1 << -ahead
        return True

    def _within_caps(self, now: int) -> bool:
        """A token bucket for the rate, and the measurement's age."""
        self._allowance += max(0, now - self._last) * 1e-9 * self.caps.rate
        self._allowance = min(self._allowance, self._burst)
        self._last = max(now, self._last)
        if now - self._since > self.caps.duration * 1e9 or self._allowance < 1.0:
            return False
        self._allowance -= 1.0
        return True


def serve(
    link: socket.socket, relay: Relay, *, stop: Callable[[], bool], report: Callable[[], None]
) -> None:
    """Relay until ``stop`` says so; ``report`` is called about twice a second."""
    transport = UdpTransport(link)
    buffer = memoryview(bytearray(LARGEST_READ))
    next_report = 0
    while not stop():
        ready, _, _ = select.select([link], [], [], 0.25)
        while ready:
            try:
                size, sender = link.recvfrom_into(buffer)
            except OSError:
                break
            answer = relay.take(buffer[:size], sender, transport.arrival(), time.monotonic_ns)
            if answer is not None:
                with contextlib.suppress(OSError):
                    link.sendto(answer, sender)
        if time.monotonic_ns() >= next_report:
            next_report = time.monotonic_ns() + 500_000_000
            report()
