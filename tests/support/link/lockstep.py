"""Two stations over real UDP sockets and the real proxy, in the test's own time.

Every datagram goes through the kernel; only the clock is not the machine's. A reader waits for what
is known to be on its way, so a busy machine makes such a test slower and changes nothing in it.
"""

from __future__ import annotations

import time

from cosim.link.wire.address import Address
from cosim.link.wire.packet import LARGEST_DATAGRAM
from cosim.link.wire.sockets import open_socket
from cosim.link.wire.transport import UdpTransport
from cosim.testing.proxy import Mangler, Proxy
from tests.support.link.simulated import SkewedClock
from tests.support.link.world import SimulatedStation, share_session

LOCAL = Address("127.0.0.1", 0)
PATIENCE = 60.0
START = 10**9


class LockStepTransport(UdpTransport):
    """Reads until ``expected`` datagrams have come out of the socket or were dropped before it."""

    def __init__(self, link) -> None:
        super().__init__(link)
        self.expected = 0
        self.arrived = 0
        self.now = 0

    def receive(self, buffer: memoryview) -> int:
        end = time.monotonic() + PATIENCE
        while self.arrived + self.dropped_by_kernel < self.expected and not self._poll.poll(10):
            assert time.monotonic() < end, "a datagram is neither there nor counted as dropped"
        size = super().receive(buffer)
        self.arrived += size >= 0
        return size

    def arrival(self) -> int:
        return self.now


class UdpWorld:
    """Stations a and b with a session, and a proxy between them; a context manager."""

    def __init__(self, forward: Mangler, backward: Mangler, **settings) -> None:
        socket_b = open_socket(LOCAL, None)
        self.proxy = Proxy(LOCAL, Address(*socket_b.getsockname()), forward, backward)
        socket_b.connect(self.proxy.inner_address.resolve()[1])
        socket_a = open_socket(LOCAL, self.proxy.address)
        self.transports = LockStepTransport(socket_a), LockStepTransport(socket_b)
        clock = SkewedClock()
        self.a, self.b = (
            SimulatedStation(*names, None, clock, transport=transport, **settings)
            for names, transport in zip(("ab", "ba"), self.transports, strict=True)
        )
        share_session(self.a, self.b)
        for station in (self.a, self.b):
            station.begin(START)

    def run(self, ticks: int) -> None:
        """Tick after tick: a, b, and after each of them the proxy."""
        for _ in range(ticks):
            for station, transport in zip((self.a, self.b), self.transports, strict=True):
                transport.now = round(station.deadline)
                station.run_tick()
                self._pass_on(transport.now)

    def _pass_on(self, now: int) -> None:
        end = time.monotonic() + PATIENCE
        while self.proxy.taken < self.a.link.outgoing.sent + self.b.link.outgoing.sent:
            self.proxy.take_in(now)
            assert time.monotonic() < end, "the proxy has not got what was sent"
        there, back = self.proxy.release(now)
        self.transports[1].expected += there
        self.transports[0].expected += back

    def __enter__(self) -> UdpWorld:
        return self

    def __exit__(self, *_) -> None:
        self.proxy.close()
        for transport in self.transports:
            transport.socket.close()


TOO_LONG = LARGEST_DATAGRAM + 1
