"""The link's sockets: bound for one station alone, connected to a peer, sent with priority."""

from __future__ import annotations

import contextlib
import errno
import socket
from collections.abc import Sequence
from typing import Any

from cosim.base.errors import InputError
from cosim.link.wire.address import Address
from cosim.link.wire.kernel_filter import attach, size_filter

RECEIVE_BUFFER = 1 << 17
"""Bytes the kernel may queue: some hundred packets, so a flood is dropped there and not stored."""
EXPEDITED = 46 << 2
"""DSCP EF (expedited forwarding) in the byte that carries it."""
INTERACTIVE = 6
"""The highest queue priority that needs no privilege (Linux)."""


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
