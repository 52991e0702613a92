"""A stream that comes from the peer, with what is made of it at each tick."""

from __future__ import annotations

from typing import Any

from cosim.link.stream.admission import PacketJudge
from cosim.link.stream.bundle import FieldRole, PacketBundle
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer import PeerState, PeerWeight
from cosim.link.stream.receiver import Receiver, ReceiverSettings, Release
from cosim.link.stream.waiting import SPARE_SLOTS

LARGEST_AGE = 2**31 - 1
"""Ages and ticks are shown no larger: models take them as 32-bit integers."""
ACTIVE = 2
FAULT = 4
"""Bits of a status field (docs/protocol.md)."""


class Incoming:
    """Held values, their age and the peer's weight; ticks are session ticks."""

    def __init__(self, bundle: PacketBundle, setting: LinkForm, judge: PacketJudge) -> None:
        self.setting = setting
        self.weight = PeerWeight(setting, period=bundle.period, tick=bundle.tick)
        delay = setting.least_delay
        self.receiver = Receiver(
            bundle,
            ReceiverSettings(
                release=Release(setting.release),
                delay=delay,
                longest_wait=setting.longest_wait,
                late_after=delay * bundle.period + self.weight.hold,
                # A station that was held up meets the others' packets early until it has caught
                # up; they can wait.
                early=SPARE_SLOTS // 2 * bundle.period,
            ),
            judge,
        )
        self.longest_way = setting.longest_delay * bundle.period
        """The longest path (base ticks) that the stream may take."""
        self.age = 0
        """Base ticks since the held values were measured: the packet's age and the source's own."""
        self.valid = False
        self.fresh = False
        self.source_age = 0
        """As the source says: with the time for which it has meant to repeat itself."""
        self.source_stale = 0
        """Without it: base ticks since the source itself was renewed."""
        self.active = True
        self.overdue_by_network = 0
        """Packets that missed their sample because of the time on the way; the others were sent
        late, by a station that had been held up."""
        self._source_tick = -1.0
        self._source_changed = 0
        """Session tick of the packet in which the source's own tick last changed."""
        self._values: memoryview[Any] = self.receiver.values.data
        # What the loop looks at every tick is looked up once.
        self._ages = bundle.indices(FieldRole.SOURCE_AGE)
        self._statuses = bundle.indices(FieldRole.STATUS)
        self._ticks = bundle.indices(FieldRole.SOURCE_TICK)

    def allow(self, path: int) -> None:
        """Set from which age a packet is too old, where the way takes ``path`` base ticks.

        What a packet needs on this link is not late, as long as the theory allows it; what was kept
        back on the way for longer than the hold time is.
        """
        receiver, weight = self.receiver, self.weight
        period = receiver.bundle.period
        path = max(receiver.settings.delay * period, path)
        late_after = min(path, self.longest_way) + weight.hold
        receiver.allow(late_after=late_after)
        weight.first_within = late_after + 2 * period

    def release(self, tick: int, *, unheard: int, in_session: bool) -> None:
        """Show what is due at this tick and weigh the peer; ``unheard`` as in its weight."""
        receiver, weight = self.receiver, self.weight
        self.fresh = receiver.release(tick)
        if self.fresh:
            self._inspect()
        age = tick - receiver.tick if receiver.tick >= 0 else tick
        self.age = min(max(0, age) + self.source_age, LARGEST_AGE)
        weight.update(
            fresh=self.fresh,
            source_age=self.source_stale,
            active=self.active and not receiver.stopping and in_session,
            unheard=unheard,
            late=receiver.last_late >= 0 and tick - receiver.last_late <= weight.hold,
        )
        receiver.held = weight.state is PeerState.FADING
        # A source that is no longer active fades before it is declared invalid: an input that
        # switches a force off at once would be a jump on the hand.
        self.valid = weight.weight > 0.0

    def _inspect(self) -> None:
        """Of newly released values, find the source's age and whether it is active."""
        values, age, active = self._values, 0, True
        for index in self._ages:
            age = max(age, int(values[index]))
        stale = age - self.receiver.repeated
        for index in self._ticks:
            # A source that stands still is as old as its last change, whatever it says itself.
            if values[index] != self._source_tick:
                self._source_tick = values[index]
                self._source_changed = self.receiver.tick
            standing = self.receiver.tick - self._source_changed
            age, stale = max(age, standing), max(stale, standing)
        self.source_age = min(age, LARGEST_AGE)
        self.source_stale = min(max(0, stale), LARGEST_AGE)
        for index in self._statuses:
            active = active and int(values[index]) & (ACTIVE | FAULT) == ACTIVE
        self.active = active
