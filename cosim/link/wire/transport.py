"""A connected, non-blocking UDP socket that never raises in the loop and stamps arrivals."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import select
import socket
import struct
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from cosim.base.errors import InputError
from cosim.link.wire.kernel_filter import attach, dropped, session_filter, size_filter

if sys.platform != "win32":
    import fcntl

RECEIVE_BUFFER = 1 << 17
"""Bytes the kernel may queue: some hundred packets, so a flood is dropped there and not stored."""
LARGEST_READ = 2048
EXPEDITED = 46 << 2
"""DSCP EF (expedited forwarding) in the byte that carries it."""
INTERACTIVE = 6
"""The highest queue priority that needs no privilege (Linux)."""
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


Place = tuple[socket.AddressFamily, tuple[Any, ...]]
"""A family and what the system takes as an address there."""


@dataclass(frozen=True, slots=True)
class Address:
    """A host and a UDP port."""

    host: str
    port: int

    @classmethod
    def parse(cls, text: str, what: str) -> Address:
        """``host:port`` or ``[ipv6]:port``.

        Raises:
            InputError: it is neither.
        """
        host, colon, port = text.rpartition(":")
        host = host.removeprefix("[").removesuffix("]")
        if not colon or not host or not port.isdecimal():
            message = f"{what} is host:port, for example 127.0.0.1:47000, and not {text!r}"
            raise InputError(message)
        if int(port) > 65535:
            message = f"{what} {text}: a port is a number up to 65535"
            raise InputError(message)
        return cls(host, int(port))

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def places(self) -> list[Place]:
        """Every family and numeric address that the name stands for, the preferred one first.

        Raises:
            InputError: the host is unknown.
        """
        try:
            found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_DGRAM)
        except OSError as error:
            message = f"the host {self.host} cannot be found: {error.strerror}"
            raise InputError(message) from None
        return [(family, place) for family, _, _, _, place in found]

    def resolve(self) -> Place:
        """The preferred one of :meth:`places`."""
        return self.places()[0]

    @property
    def is_loopback(self) -> bool:
        """Whether no other machine can reach it."""
        hosts = (str(place[0]).partition("%")[0] for _, place in self.places())
        return all(ipaddress.ip_address(host).is_loopback for host in hosts)


def refuse_open_network(addresses: list[Address], *, has_key: bool) -> None:
    """Without a key, a link may only talk to its own machine.

    Raises:
        InputError: an address is not loopback and there is no key.
    """
    for address in addresses:
        if not has_key and not address.is_loopback:
            message = (
                f"{address} can be reached from other machines and there is no key: anybody could "
                "push on the user's hand. Make a key with 'cohaptic keygen FILE', copy it to every "
                "station, and give it with --key FILE"
            )
            raise InputError(message)


def open_socket(listen: Address, peer: Address | None) -> socket.socket:
    """A non-blocking UDP socket bound to ``listen`` and connected to ``peer``.

    Raises:
        InputError: the address is in use or not of this machine, or the peer's cannot be reached
            from it.
    """
    return _open(listen, peer, shared=False)


def open_sockets(listen: Address, peers: Sequence[Address]) -> list[socket.socket]:
    """One socket for each peer, all bound to ``listen``, each connected to its own peer.

    Nobody else gets at that port, not even another process of this user.

    Raises:
        InputError: as :func:`open_socket`.
    """
    links: list[socket.socket] = []
    try:
        for peer in peers:
            # The first one finds the port free; only then it is shared, and only until all are in.
            links.append(_open(listen, peer, shared=bool(links)))
            if len(peers) > 1:
                links[-1].setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        if len(peers) > 1:
            for link in links:
                link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 0)
    except BaseException:
        for link in links:
            link.close()
        raise
    return links


def _open(listen: Address, peer: Address | None, *, shared: bool) -> socket.socket:
    family, place, there = _one_family(listen, peer)
    link = socket.socket(family, socket.SOCK_DGRAM)
    try:
        link.setblocking(False)
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        attach(link, size_filter())
        prefer(link)
        if shared:
            link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        link.bind(place)
    except OSError as error:
        link.close()
        hint = ""
        if error.errno == errno.EADDRINUSE:
            hint = "; does this station run already, or another program at that port?"
        message = f"cannot listen on {listen}: {error.strerror}{hint}"
        raise InputError(message) from None
    try:
        if there is not None:
            link.connect(there)
    except OSError as error:
        link.close()
        message = f"cannot send from {listen} to {peer}: {error.strerror}"
        raise InputError(message) from None
    return link


def prefer(link: socket.socket) -> None:
    """Ask routers and the own queues to send these packets first (RFC 3246, RFC 8325 for Wi-Fi).

    A system that does not know of it is no worse than before.
    """
    # The class first: to set it resets the queue's priority to 4.
    if link.family is socket.AF_INET6:
        _try_option(link, socket.IPPROTO_IPV6, getattr(socket, "IPV6_TCLASS", None), EXPEDITED)
    _try_option(link, socket.IPPROTO_IP, getattr(socket, "IP_TOS", None), EXPEDITED)
    _try_option(link, socket.SOL_SOCKET, getattr(socket, "SO_PRIORITY", None), INTERACTIVE)


def _try_option(link: socket.socket, level: int, option: int | None, value: int) -> None:
    if option is not None:
        with contextlib.suppress(OSError):
            link.setsockopt(level, option, value)


def _one_family(
    listen: Address, peer: Address | None
) -> tuple[socket.AddressFamily, tuple[Any, ...], tuple[Any, ...] | None]:
    """Addresses of both ends that can talk: names may stand for IPv4 and IPv6 addresses."""
    if peer is None:
        return *listen.resolve(), None
    theirs = peer.places()
    for family, place in listen.places():
        for other, there in theirs:
            if other != family:
                continue
            if place == there and listen.port:
                message = (
                    f"{listen} is this station's own address and the peer's: give each its own"
                )
                raise InputError(message)
            return family, place, there
    message = f"{listen} and {peer} are of two kinds, IPv4 and IPv6: give both of one"
    raise InputError(message)


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
