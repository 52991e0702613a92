"""How much of a peer still counts: hold, fade out, wait for good packets, come back slowly.

The weight scales every stiffness and damping that comes from the peer, so a lost peer's force goes
to zero without a jump while the own loop stays alive.
"""

from __future__ import annotations

import math
from enum import IntEnum
from fractions import Fraction

from cosim.link.stream.form import LossPolicy


class PeerState(IntEnum):
    """Where the peer stands; recorded as a number."""

    WAITING = 0
    """Nothing has come yet: zero force."""
    LIVE = 1
    HOLDING = 2
    """Packets are missing or stale; the last values still count in full."""
    FADING = 3
    """The weight goes to 0 on the values that were held when the peer was given up."""
    LOST = 4
    RESUMING = 5


class Reason(IntEnum):
    """Why a peer does not count in full; recorded as a number."""

    NONE = 0
    WAITING = 1
    """Nothing has come yet, or not yet enough to trust it."""
    SILENT = 2
    """No packet came in time, or none at all."""
    TOO_LATE = 3
    """Packets come, and take longer than ``max_delay`` allows."""
    UNHEARD = 4
    """The peer does not acknowledge what this side sends."""
    STALE = 5
    """The peer's own source of values stands still or is older than the hold time."""
    INACTIVE = 6
    """The peer's source is not active, or it has announced its stop."""
    STALLED = 7
    """The own loop stood still for longer than the hold time."""


_LIVE = PeerState.LIVE


class PeerWeight:
    """The weight of one peer, advanced once every base tick."""

    def __init__(self, policy: LossPolicy, *, period: int, tick: Fraction) -> None:
        self.policy = policy
        self.state = PeerState.WAITING
        self.reason = Reason.WAITING
        self.weight = 0.0
        """0..1, the ``peer_weight`` of this tick."""
        self.losses = 0
        """How often the peer was given up."""
        self.causes = [0] * len(Reason)
        """How often for each :class:`Reason`."""
        self.hold = max(
            1, min(policy.hold_samples * period, math.ceil(Fraction(policy.hold) / tick))
        )
        """Base ticks that values may be overdue, or a source stale, before the fade begins."""
        self._fade_step = 1.0 / max(1, math.ceil(Fraction(policy.fade) / tick))
        self._resume_step = 1.0 / max(1, math.ceil(Fraction(policy.resume) / tick))
        self._overdue_after = period
        self._silence = 0
        self._good = 0
        self._ramps = policy.ramp_at_start
        self._waited = 0
        self.first_within = self.hold + 16 * period
        """Base ticks after the start within which a first packet needs no ramp: all began then."""

    def ramp(self) -> None:
        """Come back, or come first, with good samples and a ramp from 0."""
        self._ramps = True

    def give_up(self, reason: Reason) -> None:
        """Fade from the present weight on; no more where it fades or is gone already."""
        self._ramps = True
        self._good = 0
        if self.state in {PeerState.LIVE, PeerState.HOLDING, PeerState.RESUMING}:
            self.losses += 1
            self.causes[reason] += 1
            self.reason = reason
            self.state = PeerState.FADING

    def update(
        self, *, fresh: bool, source_age: int, active: bool, unheard: int = 0, late: bool = False
    ) -> float:
        """Advance one tick.

        ``fresh`` says that a packet was released at this tick, ``source_age`` how old the peer's
        own data are beyond the packet's age (base ticks), ``active`` that its source is active and
        it has not announced a stop, ``unheard`` for how long (base ticks, beyond what the way
        takes) it has acknowledged nothing new, ``late`` that packets come, but too late to be used.
        """
        self._silence = 0 if fresh else self._silence + 1
        if self._is_untroubled(source_age, active=active, unheard=unheard):
            self._good += fresh
            return self.weight
        overdue = max(self._silence, source_age) - self._overdue_after
        reason = self._reason(source_age, active=active, unheard=unheard, late=late)
        if reason is not Reason.NONE:
            self._good = 0
        elif fresh:
            self._good += 1
        match self.state:
            case PeerState.WAITING:
                self._wait(reason)
            case PeerState.LIVE | PeerState.HOLDING:
                if reason is not Reason.NONE:
                    self.give_up(reason)
                    self._fade()
                else:
                    self.state = PeerState.HOLDING if overdue > 0 else PeerState.LIVE
            case PeerState.RESUMING:
                if reason is not Reason.NONE:
                    self.give_up(reason)
                    self._fade()
                else:
                    self.weight = min(1.0, self.weight + self._resume_step)
                    if self.weight >= 1.0:
                        self._become_live()
            case PeerState.FADING:
                self._fade()
            case PeerState.LOST:
                self._await_return(reason)
        return self.weight

    def _is_untroubled(self, source_age: int, *, active: bool, unheard: int) -> bool:
        """Whether a peer that counts in full goes on to do so: nearly every tick of a good link."""
        return (
            self.state is _LIVE
            and active
            and self._silence <= self._overdue_after
            and source_age <= self._overdue_after
            and unheard < self.hold
        )

    def _reason(self, source_age: int, *, active: bool, unheard: int, late: bool) -> Reason:
        if not active:
            return Reason.INACTIVE
        if self._silence - self._overdue_after >= self.hold:
            return Reason.TOO_LATE if late else Reason.SILENT
        if source_age - self._overdue_after >= self.hold:
            return Reason.STALE
        return Reason.UNHEARD if unheard >= self.hold else Reason.NONE

    def _wait(self, reason: Reason) -> None:
        self._waited += 1
        if self._waited > self.first_within:
            self._ramps = True
        if self._good >= 1 and not self._ramps:
            self._become_live()
        elif self._good >= self.policy.resume_samples:
            self.state = PeerState.RESUMING
        elif reason is Reason.TOO_LATE:
            self.reason = reason

    def _await_return(self, reason: Reason) -> None:
        if reason is not Reason.NONE:
            self.reason = reason
        if self._good >= self.policy.resume_samples:
            self.state = PeerState.RESUMING
            self.reason = Reason.WAITING

    def _become_live(self) -> None:
        self.weight = 1.0
        self.state = PeerState.LIVE
        self.reason = Reason.NONE
        self._ramps = True

    def _fade(self) -> None:
        self.weight = max(0.0, self.weight - self._fade_step)
        if self.weight == 0.0:
            self.state = PeerState.LOST
