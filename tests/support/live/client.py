"""A live page's server as an unfriendly program sees it."""

from __future__ import annotations

import base64
import json
import os
import socket
import struct
from contextlib import contextmanager
from urllib.parse import urlsplit


@contextmanager
def served(wanted: str | None = "nothing", **more):
    """A server's address while it serves."""
    from cosim.live.process import ServerProcess

    with ServerProcess(("127.0.0.1", 0), wanted, **more) as server:
        yield urlsplit(server.address())


def ask(address, path="/", method="GET", *, host=None, **headers) -> tuple[int, dict, bytes]:
    """Status, headers and body of one request; ``host`` replaces the server's own."""
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host or address.netloc}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    with socket.create_connection((address.hostname, address.port), timeout=5) as link:
        link.sendall("\r\n".join([*lines, "", ""]).encode())
        data = b""
        while part := link.recv(65536):
            data += part
    return parsed(data)


def parsed(data: bytes) -> tuple[int, dict, bytes]:
    """Status, headers and body of an answer."""
    head, _, body = data.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    pairs = (line.partition(": ") for line in rest)
    return int(first.split()[1]), {name.lower(): value for name, _, value in pairs}, body


def upgrade_headers(address, token=None) -> dict[str, str]:
    """What our page asks for its socket with."""
    return {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec_WebSocket_Version": "13",
        "Sec_WebSocket_Key": base64.b64encode(os.urandom(16)).decode(),
        "Sec_WebSocket_Protocol": f"cohaptic, {address.fragment if token is None else token}",
        "Origin": f"http://{address.netloc}",
    }


class Page:
    """An open socket, spoken frame by frame."""

    def __init__(self, address) -> None:
        self.link = socket.create_connection((address.hostname, address.port), timeout=5)
        headers = {"Host": address.netloc, **upgrade_headers(address)}
        lines = [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        self.link.sendall("\r\n".join(["GET /socket HTTP/1.1", *lines, "", ""]).encode())
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self.link.recv(1)
        self.status, self.headers, _ = parsed(head)

    def say(self, message) -> None:
        """Send one text message."""
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        size = struct.pack(">BBH", 0x81, 0xFE, len(data))
        if len(data) < 126:
            size = struct.pack(">BB", 0x81, 0x80 | len(data))
        self.link.sendall(size + bytes(4) + data)

    def hear(self) -> tuple[int, bytes]:
        """The opcode and content of the next frame."""
        first, second = self._take(2)
        size = second & 0x7F
        if size == 126:
            (size,) = struct.unpack(">H", self._take(2))
        elif size == 127:
            (size,) = struct.unpack(">Q", self._take(8))
        return first & 0x0F, self._take(size)

    def message(self, kind: str) -> dict:
        """The next message of that type."""
        while True:
            opcode, content = self.hear()
            assert opcode == 1, f"the server closed: {content!r}"
            found = json.loads(content)
            if found["type"] == kind:
                return found

    def _take(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            part = self.link.recv(size - len(data))
            assert part, "the server is gone"
            data += part
        return data

    def close(self) -> None:
        self.link.close()
