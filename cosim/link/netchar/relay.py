"""The packets of a measurement, and the side that relays them back.

It is a blocking relay with kernel receive timestamps, not a loop: it measures the network and not
the age that a loop adds. Authentication is the link's own; a reply is as long as its question, and
rate and duration are capped, so that nobody can use it to flood somebody else.
"""

from __future__ import annotations

import contextlib
import math
import select
import socket
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass

from cosim.base.errors import InputError
from cosim.link.session.answerer import Answerer
from cosim.link.session.contract import Contract
from cosim.link.session.greeting import SIZES
from cosim.link.session.keys import PreSharedKey
from cosim.link.session.live import KEEP_SIZE, LiveSession, SessionState
from cosim.link.wire.packet import HEADER, MAGIC, TAG_SIZE, VERSION, Opener, PacketKind, Sealer
from cosim.link.wire.transport import LARGEST_READ, UdpTransport
from cosim.link.wire.window import ReplayWindow

SERVER, CLIENT = "relay", "source"
CONTRACT = Contract({"netchar": 2})
PROBE = struct.Struct("<q")
"""sent (ns, client's clock)."""
ECHO = struct.Struct("<qqqQQ")
"""sent (from the probe), received, relayed (ns, server's clock), probes relayed so far, capped."""
OVERHEAD = HEADER.size + TAG_SIZE
SMALLEST = OVERHEAD + ECHO.size
LARGEST = 1232
STRANGE = 2
"""Greetings that fit no key or version after which that is said."""
_IDLE = 2_000_000_000
READS_AT_ONCE = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Caps:
    """What the relay does at most for one measurement."""

    rate: float = 20_000.0
    """Packets a second."""
    duration: float = 3600.0
    """Seconds."""

    def __post_init__(self) -> None:
        for name, value, unit in (
            ("rate", self.rate, "packets a second"),
            ("duration", self.duration, "s"),
        ):
            if not 0.0 < value < math.inf:
                message = f"a cap of {value:g} {unit} cannot be (--max-{name}); it is above 0"
                raise InputError(message)


class Relay:
    """Answers one measurement at a time; give it datagrams, it gives answers."""

    def __init__(self, key: PreSharedKey, caps: Caps) -> None:
        self.caps = caps
        self.capped = 0
        """Probes not answered because of the caps."""
        self.dropped = 0
        """Datagrams that were not authentic, or no probe of the present session."""
        self.received = 0
        self.handshakes_failed = 0
        """Greetings that came to nothing: another key, another version, noise of their size, copies
        of old ones."""
        self.refused = 0
        """Greetings answered with: busy."""
        self._answerer = Answerer(
            own=SERVER, peer=CLIENT, key=key, contract=CONTRACT, proof_of_address=True
        )
        self._session: LiveSession | None = None
        self._address: tuple[object, ...] | None = None
        self._opener: Opener | None = None
        self._sealer: Sealer | None = None
        self._plain = memoryview(bytearray(LARGEST))
        self._answer = memoryview(bytearray(LARGEST))
        self._window = ReplayWindow()
        self._capped_before = 0
        self._other_versions: list[int] = []
        self._noted: set[str] = set()
        self._since = 0
        self._last = 0
        self._allowance = 0.0

    def take(
        self, datagram: memoryview, sender: tuple[object, ...], arrived: int, now: Callable[[], int]
    ) -> memoryview | bytes | None:
        """What to send back to ``sender``, if anything."""
        size = len(datagram)
        if size > HEADER.size and _is_greeting(datagram[3], size):
            answer = self._shake_hands(bytes(datagram), sender, now())
            self.handshakes_failed += answer is None
            self.refused += answer is not None and answer[3] == PacketKind.REFUSE
            return answer
        if not SMALLEST <= size <= LARGEST or sender != self._address or self._opener is None:
            self.dropped += 1
            return None
        magic, version, kind, stream, zero, session, sequence = HEADER.unpack_from(datagram)
        expected = (MAGIC, VERSION, PacketKind.PROBE, 0, 0, self._opener.session)
        plain = self._plain[: size - OVERHEAD]
        authentic = (magic, version, kind, stream, zero, session) == expected and self._opener.open(
            datagram, plain
        )
        # A copy made on the way here is not relayed: nobody multiplies packets through a relay.
        if not authentic or not self._window.is_first(sequence):
            self.dropped += 1
            return None
        if not self._within_caps(arrived):
            self.capped += 1
            return None
        self.received += 1
        (sent,) = PROBE.unpack_from(plain)
        ECHO.pack_into(
            plain, 0, sent, arrived, now(), self.received, self.capped - self._capped_before
        )
        answer = self._answer[:size]
        assert self._sealer is not None
        self._sealer.seal(PacketKind.ECHO, 0, plain, answer)
        return answer

    def notes(self) -> list[str]:
        """What to tell who serves, each sentence once: anybody may have sent what it is of."""
        due: dict[str, str] = {}
        if len(self._other_versions) >= STRANGE:
            due["version"] = (
                f"version {self._other_versions[0]} of the link's protocol comes here, and this is "
                f"version {VERSION}: run one version of cohaptic on both"
            )
        if self._answerer.drops.foreign >= STRANGE:
            due["key"] = "what comes does not fit the key: do both ends have the same key file?"
        if self.refused:
            due["busy"] = "somebody else wants to measure meanwhile, and is told to wait"
        fresh = due.keys() - self._noted
        self._noted |= fresh
        return [due[about] for about in sorted(fresh)]

    def _shake_hands(self, datagram: bytes, sender: tuple[object, ...], now: int) -> bytes | None:
        busy = self._address not in {None, sender} and now - self._last < _IDLE
        answerer = self._answerer
        answerer.busy = busy
        if datagram[:2] == MAGIC and datagram[2] != VERSION:
            self._other_versions.append(datagram[2])
            del self._other_versions[STRANGE:]
            return None
        if busy and len(datagram) == KEEP_SIZE:
            return None
        # Whoever has not shown that he is where he says gets a cookie, and nothing else.
        outcome = answerer.receive(datagram, now, now, repr(sender).encode())
        session = answerer.current
        if session is not None and session is not self._session:
            self._session = session
            self._address = sender
            keys = session.keys
            self._opener = Opener(keys.incoming, keys.session)
            self._sealer = Sealer(keys.outgoing, keys.session)
            self._window, self.received = ReplayWindow(), 0
            self._capped_before = self.capped
            self._since = self._last = now
            self._allowance = self._burst
        if outcome.keep is not None and session is not None:
            return session.write(now, 0, SessionState.NONE)
        return outcome.answer

    @property
    def _burst(self) -> float:
        return max(32.0, self.caps.rate * 0.05)

    def _within_caps(self, now: int) -> bool:
        """A token bucket for the rate, and the measurement's age."""
        self._allowance += max(0, now - self._last) * 1e-9 * self.caps.rate
        self._allowance = min(self._allowance, self._burst)
        self._last = max(now, self._last)
        if now - self._since > self.caps.duration * 1e9 or self._allowance < 1.0:
            return False
        self._allowance -= 1.0
        return True


def _is_greeting(kind: int, size: int) -> bool:
    return SIZES.get(kind) == size or (kind, size) == (PacketKind.KEEP, KEEP_SIZE)


def serve(
    link: socket.socket, relay: Relay, *, stop: Callable[[], bool], report: Callable[[], None]
) -> None:
    """Relay until ``stop`` says so; ``report`` is called about twice a second."""
    transport = UdpTransport(link)
    buffer = memoryview(bytearray(LARGEST_READ))
    next_report = 0
    while not stop():
        ready, _, _ = select.select([link], [], [], 0.25)
        # Whoever sends without end must not keep the caps and the end from being looked at.
        for _ in range(READS_AT_ONCE if ready else 0):
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
