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

from cosim.link.impairment import Impairer, Impairment
from cosim.link.transport import Address, open_socket


class Proxy:
    """One client at a time; ``forward`` and ``backward`` say what was injected.

    ``lateness`` holds by how much each release came after its time (s): what the proxy itself adds.
    """

    def __init__(
        self,
        listen: Address,
        target: Address,
        forward: Impairment,
        backward: Impairment,
        *,
        seed: int = 1,
    ) -> None:
        self.forward = Impairer(forward, seed)
        self.backward = Impairer(backward, seed + 1)
        self.lateness: list[float] = []
        self._front = open_socket(listen, None)
        self._back = open_socket(Address("127.0.0.1", 0), target)
        self._client: tuple[object, ...] | None = None
        self._queue: list[tuple[int, int, bool, bytes]] = []
        self._number = itertools.count()

    @property
    def address(self) -> Address:
        """Where it listens."""
        host, port = self._front.getsockname()[:2]
        return Address(str(host), int(port))

    def run(self, stop: threading.Event) -> None:
        """Pass datagrams until ``stop`` is set."""
        try:
            while not stop.is_set():
                self._step()
        finally:
            self._front.close()
            self._back.close()

    def _step(self) -> None:
        wait = 0.05
        if self._queue:
            wait = min(wait, max(0.0, (self._queue[0][0] - time.monotonic_ns()) * 1e-9))
        ready, _, _ = select.select([self._front, self._back], [], [], wait)
        for link in ready:
            self._take(link)
        now = time.monotonic_ns()
        while self._queue and self._queue[0][0] <= now:
            due, _, is_forward, datagram = heapq.heappop(self._queue)
            self.lateness.append((now - due) * 1e-9)
            with contextlib.suppress(OSError):
                if is_forward:
                    self._back.send(datagram)
                elif self._client is not None:
                    self._front.sendto(datagram, self._client)

    def _take(self, link: socket.socket) -> None:
        is_forward = link is self._front
        impairer = self.forward if is_forward else self.backward
        while True:
            try:
                datagram, sender = link.recvfrom(2048)
            except OSError:
                return
            if is_forward:
                self._client = sender
            for due, content in impairer.take(datagram, time.monotonic_ns()):
                heapq.heappush(self._queue, (due, next(self._number), is_forward, content))
