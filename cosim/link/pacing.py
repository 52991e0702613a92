"""The pacer of a station: ticks on the grid that the stations have agreed on.

Absolute deadlines, contiguous ticks, no catch-up burst, as any paced run; beyond that the period is
slewed to keep the phase of the leader's grid, and the door is heard now and then.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import ceil
from typing import Literal, Protocol

from cosim.errors import RunError
from cosim.link.door import Door
from cosim.link.peer import PeerState
from cosim.link.remote import Grid, RemoteStation

HEAR_EVERY = 8
"""Ticks between two looks at the door."""
TELL_EVERY = 0.25
"""Seconds between two reports to the door."""
INITIAL_EVERY = 0.02
"""Seconds between two sendings of the values before the start."""


class Lateness(Protocol):
    """Where each tick's lateness goes."""

    misses: int
    slipped: int

    def add(self, late: int) -> None:
        """One tick began ``late`` ns after its deadline."""
        ...


@dataclass(slots=True)
class Worst:
    """The least that one wants to know of lateness."""

    misses: int = 0
    slipped: int = 0
    worst: int = 0
    """ns."""

    def add(self, late: int) -> None:
        """One tick began ``late`` ns after its deadline."""
        self.worst = max(self.worst, late)


def sleep_until(deadline: int) -> None:
    """Sleep until a time of the monotonic clock (ns)."""
    left = deadline - time.monotonic_ns()
    if left > 0:
        time.sleep(left * 1e-9)


@dataclass(slots=True, kw_only=True)
class StationPacer:
    """Waits for each tick of one station. ``remotes`` are in the order of the door's peers.

    ``say`` shows a sentence before the start; ``patience`` (s) is how long to wait for the others.
    """

    grid: Grid
    remotes: Sequence[RemoteStation]
    door: Door
    say: Callable[[str], None]
    period: int
    """Base ticks of the slowest bundle: where a station may join."""
    patience: float | None = None
    prepare: Callable[[], None] | None = None
    """Called once, before this station asks for a start."""
    policy: Literal["count", "stop"] = "count"
    lateness: Lateness = field(default_factory=Worst)
    clock: Callable[[], int] = time.monotonic_ns
    sleep: Callable[[int], None] = sleep_until
    _due: float = 0.0
    _origin: int = 0
    _told: int = 0

    def start(self, tick: int) -> None:
        """Wait for the others, then exchange the values before the start until it is due.

        Raises:
            InputError: a peer's contract differs.
            RunError: nobody came.
        """
        grid = self.grid
        # Locking memory takes a good part of a second: before the others wait for this station.
        if self.prepare is not None:
            self.prepare()
        with _interruptible():
            agreed = self.door.wait_for_start(say=self.say, timeout=self.patience)
        grid.first_tick = agreed.first_tick
        first = grid.first_tick + tick
        self._origin = agreed.epoch + round(first * grid.tick_ns)
        self._due = 0.0
        for remote in self.remotes:
            remote.collect()
        self.door.go_live()
        margin = round(5e6)
        while (now := self.clock()) < self._origin - margin:
            for remote in self.remotes:
                link = remote.link
                link.send_initial(first, now, agreed.epoch)
                if link.take_initial():
                    remote.show_initial()
            self.door.hear()
            self.sleep(min(self._origin - margin, now + round(INITIAL_EVERY * 1e9)))
        if now > self._origin:
            # Too late for the first tick: join at a later one, so that the grids still agree.
            past = (now + margin - agreed.epoch) / (grid.tick_ns * self.period)
            grid.first_tick = ceil(past) * self.period - tick
            first = grid.first_tick + tick
            self._origin = agreed.epoch + round(first * grid.tick_ns)
        grid.at_deadline(first, self._origin)

    def wait(self, tick: int) -> None:
        """Return at the deadline of ``tick``.

        Raises:
            RunError: it was missed and the policy is ``stop``.
        """
        grid = self.grid
        due = self._origin + round(self._due)
        if self.clock() < due:
            self.sleep(due)
        while (now := self.clock()) < due:
            self.sleep(due)
        late = now - due
        self.lateness.add(late)
        if late >= grid.tick_ns:
            periods = int(late / grid.tick_ns)
            self.lateness.misses += 1
            self.lateness.slipped += periods
            self._due += periods * grid.tick_ns
            due = self._origin + round(self._due)
            if self.policy == "stop":
                message = (
                    f"tick {tick} began {late * 1e-6:.3g} ms after its deadline; the policy is to "
                    "stop (policy 'count' goes on)"
                )
                raise RunError(message)
        session_tick = tick + grid.first_tick
        grid.at_deadline(session_tick, due)
        self._due += grid.tick_ns * (1.0 + grid.slew)
        if tick % HEAR_EVERY == 0:
            self.door.hear()
            self._tell(session_tick, now)

    def _tell(self, tick: int, now: int) -> None:
        if now - self._told < TELL_EVERY * 1e9:
            return
        self._told = now
        lost = 0
        for number, remote in enumerate(self.remotes):
            states = [item.weight.state for item in remote.link.incoming]
            stopped = any(item.receiver.stopping for item in remote.link.incoming)
            gone = remote.link.session is None or PeerState.LOST in states or stopped
            silent = tick > _patience(self.grid) and PeerState.WAITING in states
            lost |= (gone or silent) << number
        self.door.tell(lost=lost, tick=tick, epoch=self.grid.epoch)


@contextmanager
def _interruptible() -> Generator[None]:
    """Let Ctrl-C end the waiting at once; in the loop it is a wish that is granted after a tick."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _patience(grid: Grid) -> int:
    """Session ticks that a peer gets for its first packet before it is looked for again."""
    return grid.first_tick + round(1e9 / grid.tick_ns)
