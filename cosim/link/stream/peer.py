"""How much of a peer still counts: hold, fade out, wait for good packets, come back slowly.

The weight scales every stiffness and damping that comes from the peer, so a lost peer's force goes
to zero without a jump while the own loop stays alive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction


class PeerState(IntEnum):
    """Where the peer stands; recorded as a number."""

    WAITING = 0
    """Nothing has come yet: zero force."""
    LIVE = 1
    HOLDING = 2
    """Packets are missing or stale; the last values still count in full."""
    FADING = 3
    LOST = 4
    RESUMING = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class LossPolicy:
    """When a peer is given up and how it comes back; times in seconds, samples of the link."""

    hold_samples: int = 4
    fade: float = 0.05
    resume: float = 1.0
    resume_samples: int = 16
    ramp_at_start: bool = False
    """Whether the first session, too, waits for good samples and ramps up (a hand is there)."""


class PeerWeight:
    """The weight of one peer, advanced once every base tick."""

    def __init__(self, policy: LossPolicy, *, period: int, tick: Fraction) -> None:
        self.policy = policy
        self.state = PeerState.WAITING
        self.weight = 0.0
        """0..1, the ``peer_weight`` of this tick."""
        self.losses = 0
        """How often the peer was given up."""
        self.hold = policy.hold_samples * period
        """Base ticks that values may be overdue, or a source stale, before the fade begins."""
        self._fade_step = 1.0 / max(1, math.ceil(Fraction(policy.fade) / tick))
        self._resume_step = 1.0 / max(1, math.ceil(Fraction(policy.resume) / tick))
        self._overdue_after = period
        self._silence = 0
        self._good = 0
        self._first = True

    def update(self, *, fresh: bool, source_age: int, active: bool) -> float:
        """Advance one tick.

        ``fresh`` says that a packet was released at this tick, ``source_age`` how old the peer's
        own data are beyond the packet's age (base ticks), ``active`` that its source is active and
        it has not announced a stop.
        """
        self._silence = 0 if fresh else self._silence + 1
        overdue = max(self._silence, source_age) - self._overdue_after
        bad = not active or overdue >= self.hold
        if bad:
            self._good = 0
        elif fresh:
            self._good += 1
        match self.state:
            case PeerState.WAITING:
                if self._good >= 1 and self._first and not self.policy.ramp_at_start:
                    self._become_live()
                elif self._good >= self.policy.resume_samples:
                    self.state = PeerState.RESUMING
            case PeerState.LIVE | PeerState.HOLDING:
                if bad:
                    self._give_up()
                else:
                    self.state = PeerState.HOLDING if overdue > 0 else PeerState.LIVE
            case PeerState.RESUMING:
                self.weight = min(1.0, self.weight + self._resume_step)
                if bad:
                    self._give_up()
                elif self.weight >= 1.0:
                    self._become_live()
            case PeerState.FADING:
                self._fade()
            case PeerState.LOST:
                if self._good >= self.policy.resume_samples:
                    self.state = PeerState.RESUMING
        return self.weight

    def _become_live(self) -> None:
        self.weight = 1.0
        self.state = PeerState.LIVE
        self._first = False

    def _give_up(self) -> None:
        self.losses += 1
        self._first = False
        self.state = PeerState.FADING
        self._fade()

    def _fade(self) -> None:
        self.weight = max(0.0, self.weight - self._fade_step)
        if self.weight == 0.0:
            self.state = PeerState.LOST
