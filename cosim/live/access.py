"""Who is let in: exact lists of hosts and origins, GET alone, a token that no page carries.

A page of somebody else that was led here by a name of its own (DNS rebinding) has a ``Host`` that
is not in the list; a page that connects across has a foreign ``Origin``. The token stands in the
fragment of the printed address, which no browser sends along; the page hands it over as a
subprotocol of its socket, so that it is in no address, page, cookie or log.

Foxglove takes an address and nothing else, and comes from a page or program of its own: there the
token stands in the path, and who knows it may come from anywhere.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Protocol

from cosim.base.errors import InputError

SOCKET = "/socket"
FOXGLOVE = "/foxglove/"
"""Followed by the token."""
PROTOCOL = "cohaptic"
"""The subprotocol that a page asks for, followed by the token."""
_WRONG_TOKEN = "The token is missing or wrong: open the whole address that cohaptic printed."


class Headers(Protocol):
    """Headers of a request; one may come several times."""

    def get_all(self, key: str) -> list[str]:
        """Every value of a header, without regard to case."""
        ...


@dataclass(frozen=True, slots=True)
class Denial:
    """A status and the sentence that says why."""

    status: HTTPStatus
    sentence: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """The server's own addresses, ``host:port`` as a browser writes them, and its token."""

    hosts: frozenset[str]
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)

    @property
    def origins(self) -> frozenset[str]:
        """Where a page of ours comes from."""
        return frozenset(f"http://{host}" for host in self.hosts)

    def refusal(self, method: str, path: str, headers: Headers) -> Denial | None:
        """Why a request is not answered; ``None``: it may go on."""
        if method != "GET":
            return Denial(HTTPStatus.METHOD_NOT_ALLOWED, "Only GET is answered.")
        if not _is_one_of(headers.get_all("Host"), self.hosts):
            return Denial(HTTPStatus.FORBIDDEN, "This server does not go by that name.")
        if path.startswith(FOXGLOVE):
            known = self._is_token(path.removeprefix(FOXGLOVE))
            return None if known else Denial(HTTPStatus.FORBIDDEN, _WRONG_TOKEN)
        origin = headers.get_all("Origin")
        if (origin or path == SOCKET) and not _is_one_of(origin, self.origins):
            return Denial(HTTPStatus.FORBIDDEN, "That origin is not this server's page.")
        if path == SOCKET and not self._is_known(headers.get_all("Sec-WebSocket-Protocol")):
            return Denial(HTTPStatus.FORBIDDEN, _WRONG_TOKEN)
        return None

    def _is_known(self, protocols: Sequence[str]) -> bool:
        """Whether the token was handed over."""
        offered = [each.strip() for value in protocols for each in value.split(",")]
        given = offered[1] if len(offered) == 2 and offered[0] == PROTOCOL else ""
        return self._is_token(given)

    def _is_token(self, given: str) -> bool:
        """Whether that is it, in a time that does not depend on it."""
        return hmac.compare_digest(given.encode(), self.token.encode())


def _is_one_of(values: Sequence[str], allowed: frozenset[str]) -> bool:
    return len(values) == 1 and values[0] in allowed


def listening(text: str) -> tuple[str, int]:
    """``HOST:PORT`` of ``--live-at``; port 0 takes a free one.

    Raises:
        InputError: it is not written so, or the host stands for every address of the machine.
    """
    host, colon, port = text.rpartition(":")
    host = host.strip("[]")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(
            f"--live-at: '{text}' is not written as HOST:PORT, such as 127.0.0.1:8500."
        )
    if _is_everywhere(host):
        raise InputError(
            f"--live-at: {host} stands for every address of this machine; name the one that "
            "others use, so that pages which come by another name are refused."
        )
    return host, int(port)


def _is_everywhere(host: str) -> bool:
    """However it is written: ``0`` is 0.0.0.0 to the system, too."""
    try:
        found = socket.getaddrinfo(host, None, flags=socket.AI_NUMERICHOST)
    except (OSError, UnicodeError):  # a name, or nothing at all: that is said when it is opened
        return False
    return any(ipaddress.ip_address(str(each[4][0])).is_unspecified for each in found)


def hosts_of(host: str, port: int) -> frozenset[str]:
    """How browsers on this machine and beyond name what listens there."""
    names = {host}
    try:
        loopback = ipaddress.ip_address(host).is_loopback
    except ValueError:
        loopback = host == "localhost"
    if loopback:
        names |= {"localhost"}
    return frozenset(f"[{name}]:{port}" if ":" in name else f"{name}:{port}" for name in names)
