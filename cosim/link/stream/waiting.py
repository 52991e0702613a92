"""Accepted packets that wait for the sample at which their values are shown."""

from __future__ import annotations

import sys

import numpy as np

from cosim.link.stream.bundle import Floats

SPARE_SLOTS = 16
"""Beyond one for each sample that a packet waits: for those that come early, and in a burst."""
_NEVER = sys.maxsize

Order = tuple[int, int]
"""A session's place among the sessions, and a sequence: what is larger was sent later."""


class WaitingPackets:
    """A few slots for the values of one stream; nothing grows with the number of packets.

    ``next_due`` is the session tick at which the first of them is due.
    """

    def __init__(self, size: int, longest_wait: int) -> None:
        """``size`` is the number of elements of a packet, ``longest_wait`` in samples."""
        slots = longest_wait + SPARE_SLOTS
        self.next_due = _NEVER
        self._slots: list[Floats] = list(np.zeros((slots, size)))
        # Copied as bytes: with cold caches a call of NumPy costs several microseconds.
        self._bytes = [slot.data.cast("B") for slot in self._slots]
        self._order: list[Order] = [(0, 0)] * slots
        self._tick = [0] * slots
        self._sampled = [0] * slots
        self._repeated = [0] * slots
        self._due = [0] * slots
        self._free = list(range(slots))
        self._used: list[int] = []
        """Mostly one or none."""

    def make_room(self) -> int:
        """Have a free slot; how many packets gave way for it, which are the oldest."""
        if self._free:
            return 0
        self._set_free([min(self._used, key=self._order.__getitem__)])
        return 1

    @property
    def spare(self) -> Floats:
        """Shape (size,): where :meth:`keep` finds the values of the next packet."""
        return self._slots[self._free[-1]]

    def keep(self, order: Order, tick: int, sampled: int, due: int, repeated: int = 0) -> None:
        """Let what is in :attr:`spare`, of session tick ``tick``, wait until ``due``.

        ``sampled`` is the same tick as its sender counts, ``repeated`` for how many it has been the
        same.
        """
        slot = self._free.pop()
        self._used.append(slot)
        self._order[slot] = order
        self._tick[slot] = tick
        self._sampled[slot] = sampled
        self._repeated[slot] = repeated
        self._due[slot] = due
        self.next_due = min(self.next_due, due)

    def take(self, now: int, out: memoryview) -> tuple[Order, int, int, int, int]:
        """Copy the freshest values that are due to ``out``; at least one packet has to be.

        Returns their order, their session tick here and at their sender, how many older packets
        went with them, and for how many ticks they have been the same.
        """
        # Mostly one packet waits.
        if len(self._used) == 1:
            best = self._used.pop()
            self._free.append(best)
            self.next_due = _NEVER
            out[:] = self._bytes[best]
            return self._order[best], self._tick[best], self._sampled[best], 0, self._repeated[best]
        due = [slot for slot in self._used if self._due[slot] <= now]
        best = max(due, key=self._order.__getitem__)
        order = self._order[best]
        out[:] = self._bytes[best]
        done = [slot for slot in self._used if self._order[slot] <= order]
        self._set_free(done)
        repeated = self._repeated[best]
        return order, self._tick[best], self._sampled[best], len(done) - 1, repeated

    def _set_free(self, slots: list[int]) -> None:
        for slot in slots:
            self._used.remove(slot)
            self._free.append(slot)
        self.next_due = min([self._due[slot] for slot in self._used], default=_NEVER)
