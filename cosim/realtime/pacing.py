"""Real time around the loop: wait for each tick's deadline, then run it; never early, no burst.

Deadlines are absolute: tick k is due at start + k periods, on a grid. After an overrun tick numbers
stay contiguous, and one of two things happens. Without ``catch_up`` the grid moves by whole periods
and the slip is counted. With it the grid stays, and the following ticks come up to that share of a
period sooner after one another until they are back on it: two stations' ticks then still mean the
same instants.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Literal, Protocol

from cosim.base.errors import RunError
from cosim.realtime.deadlines import Deadlines, MissCause

Policy = Literal["count", "stop"]
LONGEST_SPIN = 100e-6
"""Nobody busy-waits longer than this before a deadline (s)."""
LONGEST_CATCH_UP = 0.1
"""Lag (s) that is still caught up; beyond it the grid moves."""


class Pacer(Protocol):
    """Waits before each tick."""

    @property
    def work(self) -> Work | None:
        """Where the loop notes how long the parts of a tick took; ``None``: nobody asks."""
        ...

    def start(self, tick: int) -> None:
        """The loop is about to run ``tick`` and those after it."""
        ...

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may run."""
        ...


class Work:
    """How long the parts of a tick take (ns): every call to a component, and the loop's rest."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.last: list[int] = []
        self.total: list[int] = []
        self.worst: list[int] = []
        self.ticks = 0

    def begin(self, names: list[str]) -> None:
        """The loop's parts, known before its first tick."""
        self.names = names
        self.last, self.total, self.worst = ([0] * len(names) for _ in range(3))
        self.ticks = 0

    def add(self, part: int, spent: int) -> None:
        """A part took ``spent`` ns in this tick."""
        self.last[part] = spent
        self.total[part] += spent
        self.worst[part] = max(self.worst[part], spent)

    def longest(self) -> str | None:
        """The part that took longest in the last tick."""
        return max(zip(self.last, self.names, strict=True), default=(0, None))[1]

    def summary(self) -> dict[str, dict[str, float]]:
        """Mean a tick and worst of each part (s)."""
        ticks = max(self.ticks, 1)
        return {
            name: {"mean": total / ticks * 1e-9, "worst": worst * 1e-9}
            for name, total, worst in zip(self.names, self.total, self.worst, strict=True)
        }


def sleep_until(deadline: int) -> None:
    """Sleep until a time of the monotonic clock (ns)."""
    left = deadline - time.monotonic_ns()
    if left > 0:
        time.sleep(left * 1e-9)


@dataclass(slots=True, kw_only=True)
class DeadlinePacer:
    """Absolute deadlines, ``tick_seconds`` apart (s).

    A miss is a tick that begins a whole period or more after the moment it was meant for: its place
    on the grid or, while an earlier miss is being caught up, the shortest allowed time after its
    predecessor. ``stop`` raises ``RunError`` then; ``count`` goes on. ``spin`` (s) busy-waits the
    last stretch. ``clock`` and ``sleep`` are in ns, ``busy`` is the loop's processor time in ns.
    """

    tick_seconds: Fraction
    policy: Policy = "count"
    catch_up: float = 0.0
    spin: float = 0.0
    clock: Callable[[], int] = time.monotonic_ns
    sleep: Callable[[int], None] = sleep_until
    busy: Callable[[], int] = time.thread_time_ns
    deadlines: Deadlines = field(default_factory=Deadlines)
    work: Work | None = field(default_factory=Work)
    due: int = field(default=0, init=False)
    """Where the present tick lies on the grid (ns)."""
    _nominal: float = field(default=0.0, init=False)
    _period: float = field(default=0.0, init=False)
    _gap: int = field(default=0, init=False)
    _early: int = field(default=0, init=False)
    _origin: int = field(default=0, init=False)
    _first: int = field(default=0, init=False)
    _tick: int = field(default=0, init=False)
    _began: int = field(default=0, init=False)
    _spent: int = field(default=0, init=False)

    def start(self, tick: int, at: int | None = None) -> None:
        """Tick ``tick`` is due ``at`` (ns), or now."""
        self._nominal = self._period = float(self.tick_seconds * 1_000_000_000)
        self._gap = round((1.0 - self.catch_up) * self._nominal) if self.catch_up else 0
        self._early = round(min(self.spin, LONGEST_SPIN) * 1e9)
        self._first = self._tick = tick
        self._origin = self.due = self.clock() if at is None else at
        self._began = self._origin - round(self._nominal)
        self._spent = self.busy()

    def slew(self, share: float) -> None:
        """From the present tick on, let periods be longer by ``share`` of one."""
        period = self._nominal * (1.0 + share)
        if period != self._period:
            # The present tick keeps its place; those after it get theirs from there.
            self._origin, self._first, self._period = self.due, self._tick, period

    def wait(self, tick: int) -> None:
        """Return at the deadline of ``tick``.

        Raises:
            RunError: it was missed, and the policy is ``stop``.
        """
        entered = self.clock()
        self._tick = tick
        due = self.due = self._origin + int((tick - self._first) * self._period)
        meant = max(due, self._began + self._gap) if self._gap else due
        now = entered
        if now < meant - self._early:
            self.sleep(meant - self._early)
            now = self.clock()
        while now < meant:
            if not self._early:
                self.sleep(meant)
            now = self.clock()
        late = now - meant
        deadlines = self.deadlines
        deadlines.add(late)
        if late >= self._nominal:
            self._missed(tick, late, max(0, entered - meant))
        if now - due >= self._nominal:
            self._fallen_behind(now)
        elif meant > due:
            deadlines.caught_up += 1
        self._began = now
        if self.work is not None:
            self._spent = self.busy()
            self.work.ticks += 1

    def summary(self) -> dict[str, Any]:
        """Deadlines and what the ticks' time went into; times in s."""
        found = {**self.deadlines.summary(), "policy": self.policy}
        if self.work is not None:
            found["work"] = self.work.summary()
        return found

    def _missed(self, tick: int, late: int, overrun: int) -> None:
        """Find out why, and count it. ``overrun``: how late the tick before ended (ns)."""
        cause, part = MissCause.WAKE_UP, None
        if 2 * overrun >= late:
            worked = self.busy() - self._spent
            own = worked >= self._nominal
            cause = MissCause.WORK if own else MissCause.INTERRUPTED
            part = self.work.longest() if own and self.work is not None else None
        self.deadlines.miss(late, cause, part)
        if self.policy == "stop":
            raise RunError(
                f"tick {tick} began {late * 1e-6:.3g} ms after its deadline ({cause}); the policy "
                "is to stop (policy 'count' goes on)"
            )

    def _fallen_behind(self, now: int) -> None:
        """A whole period or more behind the grid: catch up, or move the grid."""
        periods = int((now - self.due) / self._period)
        self.deadlines.farthest = max(self.deadlines.farthest, now - self.due)
        if self.catch_up and periods * self._period <= LONGEST_CATCH_UP * 1e9:
            self.deadlines.off_grid += 1
            return
        self.deadlines.slipped += periods
        moved = round(periods * self._period)
        self._origin += moved
        self.due += moved
