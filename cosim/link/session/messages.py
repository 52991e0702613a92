"""What the loop and its handshake process say to each other through a socket pair."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Protocol

from cosim.link.session.keys import SessionKeys

# Loop to process.
DATAGRAM = struct.Struct("<cBq")
"""b"D", peer, arrival (ns); the datagram follows."""
STATUS = struct.Struct("<cq")
"""b"S", epoch (ns): the loop runs, with its grid there. The live session of every peer follows, u64
each, 0 for none: one whose data come and are acknowledged."""
ARMED = b"Y"
LIVE = b"L"
QUIT = b"Q"
# Process to loop.
OFFER = struct.Struct("<cB?Q32s32s")
"""b"O", peer, whether it is the peer of before, session, outgoing, incoming key: read under it."""
USE = struct.Struct("<cBQ")
"""b"U", peer, session: send under it from now on."""
PATH = struct.Struct("<cBqq")
"""b"A", peer, lowest round trip (ns), time there that nine packets of ten kept (ns)."""
START = struct.Struct("<cxqq")
"""b"G", epoch (ns, own clock), first tick."""
REFUSAL = b"R"
"""Followed by JSON: peer, differences."""
NOTE = b"N"
"""Followed by a sentence for who waits; nothing acts on it, for anybody may have caused it."""
FACTS = b"F"
"""Followed by JSON: what the process has counted."""
LARGEST_MESSAGE = 65_536
MOST_DIFFERENCES = 40


def refusal(peer: str, differences: Sequence[str]) -> bytes:
    """The message of a peer that runs something else: whole sentences, as many as fit."""
    kept = list(differences[:MOST_DIFFERENCES])
    while True:
        left = len(differences) - len(kept)
        more = [f"and {left} more"] if left else []
        message = REFUSAL + json.dumps({"peer": peer, "differences": kept + more}).encode()
        if len(message) <= LARGEST_MESSAGE // 2 or not kept:
            return message
        kept.pop()


class SessionTaker(Protocol):
    """What in the loop is given the sessions with one peer."""

    @property
    def session(self) -> SessionKeys | None:
        """What is sent under."""
        ...

    def offer(self, keys: SessionKeys, *, same: bool) -> None:
        """Read what comes under a session; ``same``: of the peer's process of before."""

    def use(self, session: int) -> bool:
        """Send under a session that was offered; whether it is a new one."""
        ...

    def expect(self, round_trip: int, incoming: int) -> None:
        """What the clock exchanges before the start have measured (ns)."""
