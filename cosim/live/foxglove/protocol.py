"""Messages of the Foxglove WebSocket protocol, version 1, as a server that is only looked at.

Source: the protocol's public specification (foxglove/ws-protocol, docs/spec.md). Text messages are
JSON objects with ``op``; binary ones begin with a byte that says what they are, little-endian.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, cast

from websockets.exceptions import NegotiationError
from websockets.typing import Subprotocol

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Its name in Foxglove of today, and the one before; the messages used here are the same."""
INFO = 0
WARNING = 1

_DATA = struct.Struct("<BIQ")
_TIME = struct.Struct("<BQ")
_OF_DATA = 1
_OF_TIME = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A stream that is offered; ``number`` is never used twice."""

    number: int
    topic: str
    encoding: str
    schema_name: str
    schema: str
    schema_encoding: str


def chosen_of(offered: Sequence[str]) -> Subprotocol:
    """The newest name of the protocol that a viewer knows.

    Raises:
        NegotiationError: it knows none.
    """
    for known in SUBPROTOCOLS:
        if known in offered:
            return Subprotocol(known)
    message = f"This address speaks {' and '.join(SUBPROTOCOLS)}."
    raise NegotiationError(message)


def server_info(name: str, session: str) -> str:
    """Always the first message; times are those of the server's messages."""
    said = {"op": "serverInfo", "name": name, "capabilities": ["time"], "sessionId": session}
    return _written(said)


def status(level: int, sentence: str) -> str:
    """A sentence for who looks."""
    return _written({"op": "status", "level": level, "message": sentence})


def advertise(channels: Iterable[Topic]) -> str:
    """There are these channels now, too."""
    described = [
        {
            "id": channel.number,
            "topic": channel.topic,
            "encoding": channel.encoding,
            "schemaName": channel.schema_name,
            "schema": channel.schema,
            "schemaEncoding": channel.schema_encoding,
        }
        for channel in channels
    ]
    return _written({"op": "advertise", "channels": described})


def unadvertise(numbers: Sequence[int]) -> str:
    """These channels are gone."""
    return _written({"op": "unadvertise", "channelIds": list(numbers)})


def message(subscription: int, nanoseconds: int, content: bytes) -> bytes:
    """What a channel says, to one who has subscribed to it."""
    return _DATA.pack(_OF_DATA, subscription, nanoseconds) + content


def clock(nanoseconds: int) -> bytes:
    """The time that it is in the run."""
    return _TIME.pack(_OF_TIME, nanoseconds)


@dataclass(frozen=True, slots=True)
class Wishes:
    """What one message of a viewer asks for."""

    subscribe: tuple[tuple[int, int], ...] = ()
    """Subscription and channel."""
    unsubscribe: tuple[int, ...] = ()


def heard(text: str | bytes) -> Wishes:
    """What a viewer wants; what is not understood, or not offered, is nothing."""
    try:
        found: Any = json.loads(text)
    except ValueError:
        return Wishes()
    if not isinstance(found, dict):
        return Wishes()
    said = cast("dict[str, Any]", found)
    if said.get("op") == "subscribe":
        entries = _objects(said.get("subscriptions"))
        pairs = [(_id(each.get("id")), _id(each.get("channelId"))) for each in entries]
        return Wishes(subscribe=tuple((a, b) for a, b in pairs if a is not None and b is not None))
    if said.get("op") == "unsubscribe":
        said_ids = said.get("subscriptionIds")
        known = cast("list[Any]", said_ids) if isinstance(said_ids, list) else []
        numbers = map(_id, known)
        return Wishes(unsubscribe=tuple(number for number in numbers if number is not None))
    return Wishes()


def _objects(value: Any) -> list[dict[str, Any]]:
    entries = cast("list[Any]", value) if isinstance(value, list) else []
    return [cast("dict[str, Any]", entry) for entry in entries if isinstance(entry, dict)]


def _id(value: Any) -> int | None:
    return value if type(value) is int and 0 <= value < 2**32 else None


def _written(said: dict[str, Any]) -> str:
    return json.dumps(said, separators=(",", ":"))
