"""What can become of a datagram that arrives."""

from __future__ import annotations

from enum import IntEnum


class Fate(IntEnum):
    """What became of a datagram; only the first is used, all are counted."""

    ACCEPTED = 0
    LATE = 1
    """Authentic, but older than the link allows: a packet that was kept back on the way."""
    REORDERED = 2
    """Overtaken by a newer packet whose values are already held."""
    DUPLICATE = 3
    """A second copy of a packet of the last 128 sequences."""
    REPLAYED = 4
    """Authentic, but older than the window: a copy cannot be told from an original."""
    FORGED = 5
    TRUNCATED = 6
    """Not as long as a packet of its kind and stream."""
    FOREIGN = 7
    """Another protocol, version or session (another key, or an earlier session's packet)."""
    OUT_OF_RANGE = 8
    """A value not finite, or outside its variable's range."""
    JUMP = 9
    """A value that changed faster than its variable can."""
    FLOOD = 10
    """Not looked at: more datagrams than a tick may read."""
    SUPERSEDED = 11
    """Accepted (and counted as that, too), but a newer one came before its sample did."""
    ABSURD = 12
    """Authentic, with a sequence, tick or time that cannot be, an unknown flag, or without values
    that never came."""
