"""The side that sends time-tagged, counted packets at a set rate and notes what comes back."""

from __future__ import annotations

import math
import select
import socket
import time
from collections.abc import Callable

from cosim.base.errors import InputError, RunError
from cosim.link.netchar.measurement import WINDOW, EchoKind, NetworkMeasurement
from cosim.link.netchar.relay import (
    CLIENT,
    CONTRACT,
    ECHO,
    LARGEST,
    OVERHEAD,
    PROBE,
    READS_AT_ONCE,
    SERVER,
    SMALLEST,
)
from cosim.link.session.asker import Asker
from cosim.link.session.keys import PreSharedKey, SessionKeys
from cosim.link.wire.packet import HEADER, Opener, PacketKind, Sealer
from cosim.link.wire.transport import LARGEST_READ, UdpTransport

LATEST = 1 << 62
"""No clock is so far on (ns): what a packet says is not believed because it is sealed."""


class Probe:
    """A session with a relay; each :meth:`measure` is one run of packets."""

    def __init__(self, link: socket.socket, key: PreSharedKey) -> None:
        self._link = link
        self._transport = UdpTransport(link)
        self._asker = Asker(own=CLIENT, peer=SERVER, key=key, contract=CONTRACT)
        self._buffer = memoryview(bytearray(LARGEST_READ))
        self._plain = memoryview(bytearray(LARGEST))
        self._sealer: Sealer | None = None
        self._opener: Opener | None = None
        self._capped = 0
        """Packets of the session that the relay has said its caps kept back."""

    def connect(self, timeout: float = 3.0) -> None:
        """Shake hands with the relay.

        Raises:
            RunError: nobody answers, or with another key.
        """
        end = time.monotonic() + timeout
        asker = self._asker
        while asker.current is None:
            if asker.busy:
                raise RunError(
                    "the relay is busy with another measurement; wait until that one is over"
                )
            if time.monotonic() > end:
                raise RunError(self._why_nobody())
            for question in asker.poll(time.monotonic_ns()):
                self._transport.send(question)
            select.select([self._link], [], [], 0.02)
            size = self._transport.receive(self._buffer)
            if size >= HEADER.size:
                now = time.monotonic_ns()
                outcome = asker.receive(bytes(self._buffer[:size]), self._transport.arrival(), now)
                if outcome.answer is not None:
                    self._transport.send(outcome.answer)
        self.converse(asker.current.keys)

    def converse(self, keys: SessionKeys) -> None:
        """Measure under the keys of a session with the relay."""
        self._sealer = Sealer(keys.outgoing, keys.session)
        self._opener = Opener(keys.incoming, keys.session)

    def _why_nobody(self) -> str:
        if self._asker.drops.foreign:
            return (
                "what comes from the relay's address does not fit the key: do both ends have the "
                "same key file and one version of cohaptic?"
            )
        if self._transport.refused:
            return "nothing listens at the relay's address: is 'cohaptic netchar serve' running?"
        return (
            "no relay answered: is 'cohaptic netchar serve' running there, with the same key and "
            "reachable through the firewall?"
        )

    def measure(
        self,
        *,
        rate: float,
        duration: float,
        size: int = 280,
        wait: float = 1.0,
        progress: Callable[[int, int, int], None] | None = None,
        stop: Callable[[], bool] = lambda: False,
    ) -> NetworkMeasurement:
        """Send ``rate`` packets a second of ``size`` bytes for ``duration`` seconds.

        Waits at most ``wait`` seconds for the last ones. ``progress`` gets (sent, returned,
        count). ``stop`` ends sending or waiting early; what was sent until then is the measurement.

        Raises:
            InputError: rate, duration or size make no sense.
        """
        count = check_measurement(rate, duration, size)
        assert self._sealer is not None
        self._transport.discard()
        window = max(WINDOW, math.ceil(rate * wait))
        result = NetworkMeasurement(rate, size, window=window, began=time.monotonic_ns())
        datagram = memoryview(bytearray(size))
        plain = memoryview(bytearray(size - OVERHEAD))
        period = 1e9 / rate
        start = time.monotonic_ns() + 2_000_000
        next_progress = start
        while result.count < count and not stop():
            due = start + round(result.count * period)
            now = time.monotonic_ns()
            if now < due:
                self._collect(result, due)
                continue
            result.late_sends += now - due > period / 2
            PROBE.pack_into(plain, 0, now)
            self._sealer.seal(PacketKind.PROBE, 0, plain, datagram)
            result.sent(now)
            result.unsent += not self._transport.send(datagram)
            self._collect(result, now)
            if progress is not None and now >= next_progress:
                next_progress = now + 250_000_000
                progress(result.count, result.returned, count)
        end = time.monotonic_ns() + round(wait * 1e9)
        while result.returned < result.count and time.monotonic_ns() < end and not stop():
            self._collect(result, min(end, time.monotonic_ns() + 50_000_000))
        if progress is not None:
            progress(result.count, result.returned, count)
        self._capped += result.capped
        result.end()
        return result

    def _collect(self, result: NetworkMeasurement, until: int) -> None:
        """Take what comes until ``until`` (ns); at least what is there, in bounded pieces."""
        while True:
            # Whoever sends without end must not keep the sender from its clock.
            for _ in range(READS_AT_ONCE):
                size = self._transport.receive(self._buffer)
                if size < 0:
                    break
                self._take(self._buffer[:size], result)
            left = until - time.monotonic_ns()
            # The last stretch is left to the sender's own look at the clock.
            if left <= 100_000 or not select.select([self._link], [], [], left * 1e-9 - 5e-5)[0]:
                return

    def _take(self, datagram: memoryview, result: NetworkMeasurement) -> None:
        assert self._opener is not None
        size = len(datagram)
        if size >= HEADER.size and PacketKind.HELLO <= datagram[3] <= PacketKind.KEEP:
            # The answer to a greeting that was sent twice, or what only looks like one.
            drops = self._asker.drops
            foreign = drops.foreign
            self._asker.receive(bytes(datagram), self._transport.arrival(), time.monotonic_ns())
            result.forged += drops.foreign - foreign
            result.greetings += drops.foreign == foreign
            return
        plain = self._plain[: max(0, size - OVERHEAD)]
        genuine = (
            size >= SMALLEST
            and datagram[3] == PacketKind.ECHO
            and HEADER.unpack_from(datagram)[5] == self._opener.session
            and self._opener.open(datagram, plain)
        )
        if not genuine:
            result.forged += 1
            return
        arrived = self._transport.arrival()
        sent, received, relayed, relay_count, capped = ECHO.unpack_from(plain)
        if not -LATEST < received <= relayed < LATEST:
            result.forged += 1
            return
        reply = result.reply(sent, received, relayed, arrived, relay_count)
        if reply not in {EchoKind.EARLIER, EchoKind.UNKNOWN}:
            result.capped = max(result.capped, capped - self._capped)


def check_measurement(rate: float, duration: float, size: int) -> int:
    """How many packets such a measurement sends.

    Raises:
        InputError: rate, duration or size make no sense.
    """
    if not 0.1 <= rate <= 1e5:
        message = f"a rate of {rate:g} packets a second cannot be sent; 0.1 to 100000 can"
        raise InputError(message)
    if not 0.0 < duration <= 86_400.0:
        message = f"a measurement of {duration:g} s cannot be made; above 0 and up to a day can"
        raise InputError(message)
    if not SMALLEST <= size <= LARGEST:
        message = f"a packet of {size} bytes cannot be sent; {SMALLEST} to {LARGEST} bytes can"
        raise InputError(message)
    return max(1, round(rate * duration))
