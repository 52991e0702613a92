"""A station's pace: ticks on the grid that the stations have agreed on.

The master's pacer does the waiting; here it gets its start from the others, its grid from the
leader (a follower's period is slewed), and the handshake process is heard now and then.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil
from typing import Any

from cosim.link.session.client import HandshakeProcess
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.packet import PacketFlag
from cosim.realtime.deadlines import Deadlines
from cosim.realtime.pacing import DeadlinePacer, Work

CATCH_UP = 0.4
"""Share of a period by which ticks come sooner after one another until a miss is made up."""
HEAR_EVERY = 8
"""Ticks between two looks at what the handshake process says."""
TELL_EVERY = 0.25
"""Seconds between two reports to it."""
INITIAL_EVERY = 0.02
"""Seconds between two sendings of the values before the start."""


@dataclass(slots=True, kw_only=True)
class StationPacer:
    """Waits for each tick of one station. ``remotes`` are in the order of the process's peers.

    ``say`` shows a sentence before the start; ``patience`` (s) is how long to wait for the others;
    ``idle`` is called every base tick while waiting for them, for devices that are held at zero.
    """

    pace: DeadlinePacer
    grid: Grid
    remotes: Sequence[RemoteStation]
    process: HandshakeProcess
    say: Callable[[str], None]
    period: int
    """Base ticks of the slowest bundle: where a station may join."""
    patience: float | None = None
    idle: Callable[[], bool] | None = None
    """Whether there was something to do."""
    clock: Callable[[], int] = time.monotonic_ns
    _told: int = 0

    @property
    def work(self) -> Work | None:
        """Where the loop notes how long the parts of a tick took."""
        return self.pace.work

    @property
    def deadlines(self) -> Deadlines:
        """Lateness counted so far."""
        return self.pace.deadlines

    def start(self, tick: int) -> None:
        """Wait for the others, then exchange the values before the start until it is due.

        Raises:
            InputError: a peer's contract differs.
            RunError: nobody came.
        """
        grid = self.grid
        with _interruptible():
            agreed = self.process.wait_for_start(
                say=self.say, timeout=self.patience, meanwhile=self._meanwhile
            )
        grid.first_tick = agreed.first_tick
        first = grid.first_tick + tick
        origin = agreed.epoch + round(first * grid.tick_ns)
        for remote in self.remotes:
            remote.collect()
        self.process.go_live()
        margin = round(5e6)
        sent = 0
        while (now := self.clock()) < origin - margin:
            if now - sent >= INITIAL_EVERY * 1e9:
                sent = now
                self._send_initial(first, now, agreed.epoch)
            self.process.hear()
            pause = self._meanwhile() or INITIAL_EVERY
            self.pace.sleep(min(origin - margin, now + round(pause * 1e9)))
        if now > origin:
            # Too late for the first tick: join at a later one, so that the grids still agree.
            past = (now + margin - agreed.epoch) / (grid.tick_ns * self.period)
            grid.first_tick = ceil(past) * self.period - tick
            first = grid.first_tick + tick
            origin = agreed.epoch + round(first * grid.tick_ns)
        grid.at_deadline(first, origin)
        self.pace.start(tick, origin)

    def wait(self, tick: int) -> None:
        """Return at the deadline of ``tick``.

        Raises:
            RunError: it was missed and the policy is ``stop``.
        """
        grid, pace = self.grid, self.pace
        pace.wait(tick)
        session_tick = tick + grid.first_tick
        grid.at_deadline(session_tick, pace.due)
        pace.slew(grid.slew)
        if tick % HEAR_EVERY == 0:
            self.process.hear()
            self._tell(session_tick)

    def summary(self) -> dict[str, Any]:
        """Deadlines and what the ticks' time went into; times in s."""
        return self.pace.summary()

    def _meanwhile(self) -> float | None:
        """Keep the devices company; how soon to come back (s), where there are any."""
        busy = self.idle is not None and self.idle()
        return self.grid.tick_ns * 1e-9 if busy else None

    def _send_initial(self, first: int, now: int, epoch: int) -> None:
        for remote in self.remotes:
            remote.link.outgoing.send_flagged(PacketFlag.INITIAL, first, now, epoch)
            if remote.link.take_initial():
                remote.show_initial()

    def _tell(self, tick: int) -> None:
        now = self.pace.due
        if now - self._told < TELL_EVERY * 1e9:
            return
        self._told = now
        alive = [remote.link.alive(tick) for remote in self.remotes]
        self.process.tell(self.grid.epoch, alive)


@contextmanager
def _interruptible() -> Generator[None]:
    """Let Ctrl-C end the waiting at once; in the loop it is a wish that is granted after a tick."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    stops = (signal.SIGINT, signal.SIGTERM)

    def leave(_number: int, _frame: object) -> None:
        # From a terminal the same wish comes several times, from every process of the run.
        for stop in stops:
            signal.signal(stop, signal.SIG_IGN)
        raise KeyboardInterrupt

    before = [signal.signal(number, leave) for number in stops]
    try:
        yield
    finally:
        for number, handler in zip(stops, before, strict=True):
            signal.signal(number, handler)
