"""The loop's end of a connected socket: it never waits, never raises, and stamps arrivals."""

from __future__ import annotations

import select
import socket
import struct
import sys
import time
from typing import Protocol

from cosim.link.wire.kernel_filter import attach, dropped, session_filter, size_filter

if sys.platform != "win32":
    import fcntl

LARGEST_READ = 2048
_SIOCGSTAMPNS = 0x8907
_STAMP = struct.Struct("@qq")


class Transport(Protocol):
    """What a peer's link sends and receives through."""

    def receive(self, buffer: memoryview) -> int:
        """The next datagram's size, or -1 where none waits."""
        ...

    def arrival(self) -> int:
        """When the datagram just received arrived (ns, own monotonic clock)."""
        ...

    def send(self, datagram: memoryview | bytes) -> bool:
        """Send without waiting; whether it was handed over."""
        ...

    def discard(self) -> int:
        """Throw away what waits, up to a bound; how many datagrams that was."""
        ...

    def guard(self, session: int, floor: int, *, handshakes: bool) -> None:
        """In a flood: let in data of one session from a sequence on, and perhaps handshakes."""
        ...

    def unguard(self) -> None:
        """Let everything in again that is as short as the link's datagrams."""
        ...


class UdpTransport:
    """The loop's end of a connected socket."""

    def __init__(self, link: socket.socket) -> None:
        self.socket = link
        self.refused = 0
        """Sends that met no listener (the peer has not bound its socket yet, or is gone)."""
        self.unsent = 0
        """Sends that failed otherwise: no route, full buffer."""
        # To ask first costs a sixth of a read that finds nothing, which is most of them.
        self._poll = select.poll() if hasattr(select, "poll") else None
        if self._poll is not None:
            self._poll.register(link, select.POLLIN)
        self._stamp = bytearray(_STAMP.size)
        self._bin = memoryview(bytearray(1))
        self._has_stamps = False
        if sys.platform == "linux":
            self._enable_stamps()

    def _enable_stamps(self) -> None:
        try:
            # The first request switches stamping on and finds no stamp yet.
            fcntl.ioctl(self.socket.fileno(), _SIOCGSTAMPNS, self._stamp, True)
        except FileNotFoundError:
            self._has_stamps = True
        except OSError:
            return
        else:
            self._has_stamps = True

    def receive(self, buffer: memoryview) -> int:
        """The next datagram's size, or -1 where none waits."""
        if self._poll is not None and not self._poll.poll(0):
            return -1
        try:
            return self.socket.recv_into(buffer)
        except ConnectionRefusedError:
            # An ICMP answer to an earlier send, reported here; what waits is still there.
            self.refused += 1
            return self._receive_after_refusal(buffer)
        except OSError:
            return -1

    def _receive_after_refusal(self, buffer: memoryview) -> int:
        try:
            return self.socket.recv_into(buffer)
        except OSError:
            return -1

    def arrival(self) -> int:
        """When the datagram just received reached the kernel (ns, monotonic)."""
        now = time.monotonic_ns()
        if sys.platform == "win32" or not self._has_stamps:
            return now
        try:
            fcntl.ioctl(self.socket.fileno(), _SIOCGSTAMPNS, self._stamp, True)
        except OSError:
            return now
        seconds, rest = _STAMP.unpack(self._stamp)
        waited = time.time_ns() - (seconds * 1_000_000_000 + rest)
        # A step of the wall clock in between shows as a wait that cannot be.
        return now - waited if 0 <= waited < 1_000_000_000 else now

    def send(self, datagram: memoryview | bytes) -> bool:
        """Send without waiting; a peer that is not there is no error."""
        try:
            self.socket.send(datagram)
        except ConnectionRefusedError:
            # Reports an earlier datagram; this one was not sent, so it is tried once more.
            self.refused += 1
            return self._send_again(datagram)
        except OSError:
            self.unsent += 1
            return False
        return True

    def _send_again(self, datagram: memoryview | bytes) -> bool:
        try:
            self.socket.send(datagram)
        except OSError:
            self.unsent += 1
            return False
        return True

    def discard(self) -> int:
        """Throw away up to 256 waiting datagrams, reading one byte of each."""
        for count in range(256):
            if self.receive(self._bin) < 0:
                return count
        return 256

    def guard(self, session: int, floor: int, *, handshakes: bool) -> None:
        """In a flood: let in data of one session from a sequence on, and perhaps handshakes."""
        attach(self.socket, session_filter(session, floor, handshakes=handshakes))

    def unguard(self) -> None:
        """Let everything in again that is as short as the link's datagrams."""
        attach(self.socket, size_filter())

    @property
    def dropped_by_kernel(self) -> int:
        """Datagrams that the kernel threw away: too long, kept out in a flood, or no room."""
        return dropped(self.socket)
