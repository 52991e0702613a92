"""Real time around the loop: wait for each tick's deadline, then run it; never early, no catch-up.

Deadlines are absolute: tick k is due at start + k periods. After an overrun the grid moves by whole
periods, so that tick numbers stay contiguous and nothing is run in a burst; the slip is counted.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal, Protocol

from cosim.errors import RunError

Policy = Literal["count", "stop"]


class Pacer(Protocol):
    """Waits before each tick."""

    def start(self, tick: int) -> None:
        """The loop is about to run ``tick`` and those after it."""
        ...

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may run."""
        ...


@dataclass(slots=True)
class DeadlinePacer:
    """Absolute deadlines, ``tick_seconds`` apart (s).

    A tick is late when it starts a whole period or more after its deadline. ``stop`` raises
    ``RunError`` then; ``count`` moves the grid and goes on.
    """

    tick_seconds: Fraction
    policy: Policy = "count"
    clock: Callable[[], int] = time.monotonic_ns
    sleep: Callable[[float], None] = time.sleep
    misses: int = field(default=0, init=False)
    slipped: int = field(default=0, init=False)
    """Periods by which the grid has moved."""
    worst: float = field(default=0.0, init=False)
    """Longest time from a deadline to the start of its tick (s)."""
    _origin: int = field(default=0, init=False)
    _first: int = field(default=0, init=False)

    def start(self, tick: int) -> None:
        """Tick ``tick`` is due now."""
        self._origin = self.clock()
        self._first = tick

    def wait(self, tick: int) -> None:
        """Sleep until the deadline of ``tick``.

        Raises:
            RunError: it was missed, and the policy is ``stop``.
        """
        due = self._due(tick)
        now = self.clock()
        while now < due:
            self.sleep((due - now) * 1e-9)
            now = self.clock()
        late = now - due
        self.worst = max(self.worst, late * 1e-9)
        periods = int(late * Fraction(1, 1_000_000_000) / self.tick_seconds)
        if periods == 0:
            return
        self.misses += 1
        self.slipped += periods
        if self.policy == "stop":
            raise RunError(
                f"tick {tick} started {late * 1e-6:.3g} ms after its deadline; the policy is to "
                "stop (policy 'count' goes on)"
            )

    def _due(self, tick: int) -> int:
        periods = tick - self._first + self.slipped
        # Nanoseconds do not divide 1/1024 s: each deadline is rounded by itself, none adds up.
        return self._origin + round(periods * self.tick_seconds * 1_000_000_000)
