"""Where a station is reached: a host and a port, and whether other machines can get there."""

from __future__ import annotations

import ipaddress
import socket
from dataclasses import dataclass
from typing import Any

from cosim.base.errors import InputError

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
