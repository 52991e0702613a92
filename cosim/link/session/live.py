"""A session that has keys: sealed KEEPs that prove life, compare clocks and carry the start."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntFlag

from cosim.link.session.keys import SessionKeys
from cosim.link.wire.packet import (
    HEADER,
    LARGEST_TIME,
    MAGIC,
    TAG_SIZE,
    VERSION,
    Opener,
    PacketKind,
    Sealer,
)
from cosim.link.wire.window import ReplayWindow

_BODY = struct.Struct("<qqqqII")
"""sent, echo_sent, echo_received, epoch (ns, sender's clock), state, zero."""
KEEP_SIZE = HEADER.size + _BODY.size + TAG_SIZE


class SessionState(IntFlag):
    """What a station tells about itself."""

    NONE = 0
    READY = 1
    """It has a session and a clock estimate with every peer."""
    GRID = 2
    """``epoch`` is where session tick 0 lies."""
    RUNNING = 4


_EVERY_STATE = SessionState.READY | SessionState.GRID | SessionState.RUNNING


@dataclass(frozen=True, slots=True)
class Keep:
    """An authentic KEEP, seen for the first time; times in ns."""

    sent: int
    echo_sent: int
    echo_received: int
    epoch: int
    state: SessionState
    received: int
    """Own clock."""


class LiveSession:
    """One session's KEEPs; ``heard`` and ``acknowledged`` are own times (ns)."""

    def __init__(self, keys: SessionKeys, *, instance: int, now: int) -> None:
        self.keys = keys
        self.instance = instance
        """The peer's, as it said in the handshake."""
        self.since = now
        self.heard = now
        """When a first copy last came."""
        self.acknowledged = now
        """The newest own KEEP that the peer is known to have received."""
        self.last_sent: int | None = None
        self.peer_state = SessionState.NONE
        self._sealer = Sealer(keys.outgoing, keys.session)
        self._opener = Opener(keys.incoming, keys.session)
        self._window = ReplayWindow()
        self._echo = (0, 0)

    def write(self, now: int, epoch: int, state: SessionState) -> bytes:
        """The next KEEP."""
        self.last_sent = now
        plain = _BODY.pack(now, *self._echo, epoch, state, 0)
        datagram = bytearray(KEEP_SIZE)
        self._sealer.seal(PacketKind.KEEP, 0, memoryview(plain), memoryview(datagram))
        return bytes(datagram)

    def read(self, datagram: bytes, received: int, now: int) -> Keep | None:
        """An authentic first copy; ``None`` for anything else. Only a first copy is life."""
        magic, version, kind, stream, zero, session, sequence = HEADER.unpack_from(datagram)
        if (magic, version, kind, stream, zero) != (MAGIC, VERSION, PacketKind.KEEP, 0, 0):
            return None
        plain = bytearray(_BODY.size)
        if session != self.keys.session or not self._opener.open(
            memoryview(datagram), memoryview(plain)
        ):
            return None
        if not self._window.is_first(sequence):
            return None
        *times, state, zero = _BODY.unpack(plain)
        sent, echo_sent, echo_received, epoch = times
        if zero or state > _EVERY_STATE or any(abs(time) > LARGEST_TIME for time in times):
            return None
        self._echo = (sent, received)
        self.heard = now
        if self.acknowledged < echo_sent <= now:
            self.acknowledged = echo_sent
        self.peer_state = SessionState(state)
        return Keep(sent, echo_sent, echo_received, epoch, self.peer_state, received)

    def is_due(self, now: int, interval: int) -> bool:
        """Whether ``interval`` (ns) has passed since the last KEEP was written."""
        return self.last_sent is None or now - self.last_sent >= interval


def session_of(datagram: bytes) -> int | None:
    """The session that a datagram of a KEEP's size and kind names; ``None`` for another one."""
    if len(datagram) != KEEP_SIZE or datagram[3] != PacketKind.KEEP:
        return None
    return int(HEADER.unpack_from(datagram)[5])
