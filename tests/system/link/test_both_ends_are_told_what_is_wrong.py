"""Two that cannot meet each get a true sentence, at whichever end one looks."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from cosim.link.session.keys import create_key_file
from cosim.link.session.messages import NOTE, REFUSAL
from cosim.link.session.process import HandshakeServer
from cosim.link.wire.address import Address
from cosim.link.wire.sockets import open_socket

LOCAL = Address("127.0.0.1", 0)


class End:
    """The handshake process of a station, in this one."""

    def __init__(self, own: str, peer: str, link: socket.socket, key: Path | None) -> None:
        self.loop, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.loop.setblocking(False)
        self.told: list[str] = []
        self.server = HandshakeServer(
            {
                "own": own,
                "peers": [peer],
                "addresses": ["there"],
                "sockets": [link.detach()],
                "loop": theirs.detach(),
                "key_files": [None if key is None else str(key)],
                "contracts": [{"rate": 128}],
                "tick": "1/1024",
                "period": 8,
            }
        )

    def step(self, now: int) -> None:
        self.server.step(now)
        self.server._read(0, self.server.links[0])
        while True:
            try:
                message = self.loop.recv(65536)
            except BlockingIOError:
                return
            if message[:1] in {NOTE, REFUSAL}:
                self.told.append(message[1:].decode())

    def close(self) -> None:
        for one in (self.loop, self.server.loop, self.server.links[0].socket):
            one.close()


@contextmanager
def ends(*facts: tuple[str, str, Path | None]) -> Iterator[list[End]]:
    """Two stations that look for each other; each is (own name, the peer's, key)."""
    with ExitStack() as opened:
        first = open_socket(LOCAL, None)
        second = open_socket(LOCAL, Address(*first.getsockname()))
        first.connect(second.getsockname())
        found = []
        for link, fact in zip((first, second), facts, strict=True):
            found.append(End(fact[0], fact[1], link, fact[2]))
            opened.callback(found[-1].close)
        yield found


def meet(found: list[End], seconds: int = 4) -> None:
    """Let them try; their watches run ahead of ours."""
    now = time.monotonic_ns()
    for number in range(seconds * 50):
        for end in found:
            end.step(now + number * 20_000_000)


@pytest.mark.parametrize("own", ["a", "b"])
def test_two_of_one_name(own: str) -> None:
    peer = {"a": "b", "b": "a"}[own]
    with ends((own, peer, None), (own, peer, None)) as found:
        meet(found)
        for end in found:
            (told,) = end.told
            assert told.startswith(f"the station at the address of {peer} (there) is called {own}")


def test_another_key(tmp_path) -> None:
    keys = [tmp_path / name for name in ("one", "other")]
    for key in keys:
        create_key_file(key)
    with ends(("a", "b", keys[0]), ("b", "a", keys[1])) as found:
        meet(found)
        for end, peer in zip(found, "ba", strict=True):
            (told,) = end.told
            assert f"the address of {peer} (there) does not fit the key" in told


def test_a_listener_that_serves_somebody_else(tmp_path) -> None:
    """The kernel turns a third one away, and the two go on."""
    with ends(("a", "b", None), ("b", "a", None)) as found:
        listener = Address(*found[0].server.links[0].socket.getsockname())
        third = End("b", "a", open_socket(LOCAL, listener), None)
        try:
            meet([*found, third], seconds=2)
            (told,) = third.told
        finally:
            third.close()
        assert told.startswith("nothing at the address of a (there) takes packets of this station")
        assert [end.told for end in found] == [[], []]
        assert all(end.server.negotiator.side(0).current is not None for end in found)


def test_nobody_there() -> None:
    with ends(("a", "b", None), ("b", "a", None)) as found:
        found[1].server.links[0].socket.close()
        for number in range(100):
            found[0].step(time.monotonic_ns() + number * 300_000_000)
        (told,) = found[0].told
        assert told.startswith("nothing at the address of b (there) takes packets of this station")
