"""Which sequences have been seen: a first copy counts, a second one never (RFC 6479)."""

from __future__ import annotations

WINDOW = 128
"""Sequences back from the highest for which a second copy is told from a first, late one."""
_MASK = (1 << WINDOW) - 1
LARGEST_SEQUENCE = (1 << 63) - 1
"""A year at 1024 Hz is 2**35; what is larger makes no sense, and would not fit a record."""


class ReplayWindow:
    """The last :data:`WINDOW` sequences of one kind and stream, as one integer."""

    __slots__ = ("highest", "seen")

    def __init__(self) -> None:
        self.highest = -1
        self.seen = 0

    def is_first(self, sequence: int) -> bool:
        """Mark an authentic sequence as seen; whether it is new and not older than the window."""
        ahead = sequence - self.highest
        if ahead > 0:
            if sequence > LARGEST_SEQUENCE:
                return False
            self.seen = ((self.seen << ahead) | 1) & _MASK if ahead < WINDOW else 1
            self.highest = sequence
            return True
        if self.is_old(sequence) or self.seen & (1 << -ahead):
            return False
        self.seen |= 1 << -ahead
        return True

    def is_old(self, sequence: int) -> bool:
        """Whether it is so old that a copy cannot be told from an original."""
        return self.highest - sequence >= WINDOW
