"""A UDP proxy that delays, drops, duplicates, reorders and corrupts: a bad network on one machine.

It stands in front of a station or a relay: whoever talks to ``listen`` talks to ``target``.
"""

from __future__ import annotations

import contextlib
import heapq
import itertools
import select
import socket
import threading
import time
from typing import Protocol

from cosim.link.wire.address import Address
from cosim.link.wire.sockets import open_socket
from cosim.link.wire.transport import UdpTransport


class Mangler(Protocol):
    """What happens to the datagrams of one direction."""

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        """When (ns) to deliver what, for a datagram that came at ``now`` (ns)."""
        ...


class Proxy:
    """One client at a time; ``forward`` and ``backward`` decide what becomes of each datagram.

    :meth:`run` follows the clock. A test that must not depend on it calls :meth:`take_in` and
    :meth:`release` itself, with its own times. ``lateness`` holds by how much each release came
    after its time (s): what the proxy itself adds. ``delays`` has for each direction the time (s)
    from a datagram's arrival here, as the kernel stamped it, to its release.
    """

    def __init__(
        self, listen: Address, target: Address, forward: Mangler, backward: Mangler
    ) -> None:
        self.forward = forward
        self.backward = backward
        self.taken = 0
        """Datagrams taken in, both directions together."""
        self.lateness: list[float] = []
        self.delays: tuple[list[float], list[float]] = ([], [])
        """There, back."""
        self._front = open_socket(listen, None)
        self._back = open_socket(Address("127.0.0.1", 0), target)
        self._stamps = UdpTransport(self._front), UdpTransport(self._back)
        self._client: tuple[object, ...] | None = None
        self._queue: list[tuple[int, int, int, bool, bytes]] = []
        self._number = itertools.count()

    @property
    def address(self) -> Address:
        """Where clients find it."""
        host, port = self._front.getsockname()[:2]
        return Address(str(host), int(port))

    @property
    def inner_address(self) -> Address:
        """From where it talks to the target."""
        host, port = self._back.getsockname()[:2]
        return Address(str(host), int(port))

    @property
    def idle(self) -> bool:
        """Whether nothing waits here for its time."""
        return not self._queue

    @property
    def sockets(self) -> tuple[socket.socket, socket.socket]:
        """What to wait for: that of the client, that of the target."""
        return self._front, self._back

    def run(self, stop: threading.Event) -> None:
        """Pass datagrams until ``stop`` is set."""
        try:
            while not stop.is_set():
                self._step()
        finally:
            self.close()

    def close(self) -> None:
        """Close both sockets."""
        self._front.close()
        self._back.close()

    def take_in(self, now: int | None = None) -> int:
        """Take what has arrived, each at its arrival or all at ``now`` (ns); how many."""
        before = self.taken
        self._take(self._front, self._stamps[0], now)
        self._take(self._back, self._stamps[1], now)
        return self.taken - before

    def release(self, now: int | None = None) -> tuple[int, int]:
        """Send what is due by ``now`` (ns, or by the clock); how many there and back."""
        counts = [0, 0]
        while self._queue:
            at = time.monotonic_ns() if now is None else now
            if self._queue[0][0] > at:
                break
            due, _, arrived, is_forward, datagram = heapq.heappop(self._queue)
            self.lateness.append((at - due) * 1e-9)
            self.delays[not is_forward].append((at - arrived) * 1e-9)
            counts[not is_forward] += 1
            self.send(datagram, is_forward=is_forward)
        return counts[0], counts[1]

    def send(self, datagram: bytes, *, is_forward: bool) -> None:
        """Send to the target, or to the client: also what neither of them has sent."""
        with contextlib.suppress(OSError):
            if is_forward:
                self._back.send(datagram)
            elif self._client is not None:
                self._front.sendto(datagram, self._client)

    def _step(self) -> None:
        wait = 0.05
        if self._queue:
            wait = min(wait, max(0.0, (self._queue[0][0] - time.monotonic_ns()) * 1e-9))
        select.select(self.sockets, [], [], wait)
        self.take_in()
        self.release()

    def _take(self, link: socket.socket, stamps: UdpTransport, now: int | None) -> None:
        is_forward = link is self._front
        mangler = self.forward if is_forward else self.backward
        while True:
            try:
                datagram, sender = link.recvfrom(2048)
            except OSError:
                return
            if is_forward:
                self._client = sender
            self.taken += 1
            arrived = stamps.arrival() if now is None else now
            for due, content in mangler.take(datagram, arrived):
                entry = (due, next(self._number), arrived, is_forward, content)
                heapq.heappush(self._queue, entry)
