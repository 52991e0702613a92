"""The pace of a run that is played in: the clock's, or slower, or none, as the page asks."""

from __future__ import annotations

import time
from typing import Any

from cosim.base.system.pulse import Pulse
from cosim.live.control import PlayControl
from cosim.realtime.deadlines import Deadlines
from cosim.realtime.pacing import DeadlinePacer, Work

LOOK_SECONDS = 0.002
"""From one look at a paused run's wishes to the next."""


class PlayPacer:
    """A ``DeadlinePacer`` that obeys a ``PlayControl``; ``pulse`` shows that a pause is no hang."""

    def __init__(self, inner: DeadlinePacer, control: PlayControl, pulse: Pulse) -> None:
        self._inner, self._control, self._pulse = inner, control, pulse
        self._obeyed = -1
        self._steps = 0

    @property
    def deadlines(self) -> Deadlines:
        """Lateness counted so far; a pause counts as none."""
        return self._inner.deadlines

    @property
    def work(self) -> Work | None:
        """Where the loop notes how long the parts of a tick took."""
        return self._inner.work

    def summary(self) -> dict[str, Any]:
        """Deadlines and what the ticks' time went into."""
        return self._inner.summary()

    def start(self, tick: int) -> None:
        """The loop is about to run ``tick`` and those after it."""
        self._control.look()
        self._steps = self._control.steps
        self._begin(tick)

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may run.

        Raises:
            KeyboardInterrupt: somebody has asked for the end during a pause.
            RunError: the tick is late, and the policy is to stop.
        """
        if self._control.changes != self._obeyed:
            self._obey(tick)
        if self._control.paused:
            self._pause(tick)
        self._inner.wait(tick)

    def _obey(self, tick: int) -> None:
        was_paused = self._control.paused
        self._control.look()
        self._obeyed = self._control.changes
        if not was_paused:
            self._inner.slew(1.0 / self._control.speed - 1.0)

    def _pause(self, tick: int) -> None:
        """Hold on until a step or the end of the pause is asked for."""
        while self._control.paused and self._steps >= self._control.steps:
            if self._pulse.stop_asked:
                raise KeyboardInterrupt
            self._pulse.beat()
            time.sleep(LOOK_SECONDS)
            self._control.look()
        self._steps = min(self._steps + 1, self._control.steps)
        self._begin(tick)

    def _begin(self, tick: int) -> None:
        self._obeyed = self._control.changes
        self._inner.start(tick)
        self._inner.slew(1.0 / self._control.speed - 1.0)
