"""What one period brings a receiver: which packets arrive, and at which tick of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class PeriodFate:
    """The arrivals of one link in one of its periods.

    Attributes:
        arrivals: (tick within the period, age of the packet in periods), in the order of time;
            each is newer than the one before, as receivers keep the newest.
        held: the age of what is held when the period begins, in periods; 0 where nobody reads it.
    """

    arrivals: tuple[tuple[int, int], ...]
    held: int = 0


LOST = PeriodFate(())
"""Nothing arrives."""


def on_time(delay: int, period: int) -> PeriodFate:
    """The packet that is due arrives (ticks)."""
    return PeriodFate(((delay % period, delay // period),))
