"""A viewer of the Foxglove WebSocket protocol, written from its public specification alone.

It keeps the rules that Foxglove and Lichtblick keep of channels: a JSON schema says the type of
every list's items and of every object's properties, or the channel is no use.
"""

from __future__ import annotations

import json
import struct

import numpy as np
from websockets.sync.client import connect

NEW, OLD = "foxglove.sdk.v1", "foxglove.websocket.v1"
KINDS = {"int64": "<i8", "float64": "<f8"}


class FoxgloveViewer:
    """What is advertised, and the messages of what it subscribes to."""

    def __init__(self, address: str, *protocols: str, **more) -> None:
        self._connected = connect(address, subprotocols=protocols or (NEW, OLD), **more)
        self.socket = self._connected.__enter__()
        self.protocol = self.socket.subprotocol
        self.channels: dict[int, dict] = {}
        self.subscribed: dict[int, int] = {}
        self.statuses: list[str] = []
        self.clock = None
        self.info = self._next()
        assert self.info["op"] == "serverInfo"

    def advertised(self, topic: str, seconds: float = 10.0) -> dict:
        """The channel of a topic, once it is there."""
        while not (found := [c for c in self.channels.values() if c["topic"] == topic]):
            self._next(seconds)
        return found[0]

    def subscribe(self, topic: str, seconds: float = 10.0) -> int:
        """The subscription's number."""
        channel, number = self.advertised(topic, seconds), 7 + len(self.subscribed)
        wish = {"id": number, "channelId": channel["id"]}
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": [wish]}))
        self.subscribed[number] = channel["id"]
        return number

    def message(self, seconds: float = 10.0) -> tuple[str, int, object] | None:
        """Topic, time (ns) and content of what comes next; ``None`` where it was no message."""
        found = self._next(seconds)
        return found if isinstance(found, tuple) else None

    def _next(self, seconds: float = 10.0):
        said = self.socket.recv(seconds)
        if isinstance(said, bytes):
            return self._binary(said)
        found = json.loads(said)
        if found["op"] == "advertise":
            for channel in found["channels"]:
                if channel["schemaEncoding"] == "jsonschema":
                    judge(json.loads(channel["schema"]))
                assert channel["id"] not in self.channels
                self.channels[channel["id"]] = channel
        elif found["op"] == "unadvertise":
            for number in found["channelIds"]:
                del self.channels[number]
        elif found["op"] == "status":
            self.statuses.append(found["message"])
        return found

    def _binary(self, said: bytes):
        if said[0] == 2:
            (self.clock,) = struct.unpack_from("<Q", said, 1)
            return None
        assert said[0] == 1
        subscription, time = struct.unpack_from("<IQ", said, 1)
        channel = self.channels[self.subscribed[subscription]]
        return channel["topic"], time, content(channel, said[13:])

    def close(self) -> None:
        self._connected.__exit__(None, None, None)


def judge(schema: dict) -> None:
    """Refuse a JSON schema of which no type can be made."""
    assert schema["type"] == "object"
    for entry in schema["properties"].values():
        if entry["type"] == "array":
            entry = entry["items"]
        if entry["type"] == "object":
            judge(entry)
        else:
            assert entry["type"] in {"boolean", "string", "number", "integer"}


def content(channel: dict, data: bytes):
    """A message: an object, or a row by field."""
    if channel["encoding"] == "json":
        return json.loads(data)
    assert channel["encoding"] == "cdr"
    assert data[:4] == b"\x00\x01\x00\x00"
    fields = [line.split() for line in channel["schema"].splitlines()]
    row = np.frombuffer(data[4:], np.dtype([(name, KINDS[kind]) for kind, name in fields]))
    assert len(row) == 1
    return {name: row[name][0] for _, name in fields}
