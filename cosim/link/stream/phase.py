"""The own grid follows the leader's: its period is slewed, never stepped."""

from __future__ import annotations


class PhaseFollower:
    """Slews a tick period so that the own grid keeps its phase on the leader's; never a step."""

    def __init__(self, *, limit: float = 200e-6, gain: float = 0.2) -> None:
        self.limit = limit
        """Largest relative change of the period."""
        self.gain = gain
        """Relative change per second of phase error (1/s)."""
        self.correction = 0.0
        """Relative change of the period now; 0 on a leader."""
        self.saturated = 0
        """Updates at which the limit did not suffice."""

    def update(self, phase: float, skew: float) -> float:
        """New correction from the phase (s; positive: own ticks come late) and the clock's skew.

        The skew is fed forward, so a constant drift leaves no phase error behind.
        """
        wanted = -skew - self.gain * phase
        self.correction = min(max(wanted, -self.limit), self.limit)
        self.saturated += self.correction != wanted
        return self.correction
