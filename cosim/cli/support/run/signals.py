"""Signals for a run that is a child of this process: passed on, and the last resort of Ctrl-C."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress

from cosim.master.run.whereabouts import Whereabouts

HEARD = {signal.SIGINT, signal.SIGTERM}
_HEARING_SECONDS = 0.15
"""A run hears an interrupt within a chunk of ticks, some 50 ms."""
_STUCK_SECONDS = 1.0
"""A child that does not move for so long, from one Ctrl-C to the next, does not come back."""


class Post:
    """Hands on signals that were sent to the parent alone; ends a child that never comes back.

    Ctrl-C reaches every process of the terminal's group by itself, from the kernel, and some send
    to a group: heard twice, it would be taken for the second one, which breaks off at once.

    A child is in an FMU's call that does not return when it has not moved at all from one Ctrl-C to
    a second one: nothing but its end is left.
    """

    def __init__(self, child: int, whereabouts: Whereabouts) -> None:
        self.passed_on: set[int] = set()
        self.has_broken_off = False
        """Whether the child was ended here, in the middle of a call."""
        self._child, self._whereabouts, self._heard = child, whereabouts, 0
        self._asked: tuple[float, bytes] | None = None

    def pass_on(self, seconds: float) -> None:
        """Wait so long for a signal."""
        found = signal.sigtimedwait(HEARD, seconds)
        if found is None:
            return
        if found.si_signo == signal.SIGINT:
            time.sleep(_HEARING_SECONDS)
            self._break_off_unless_it_moves()
        before, self._heard = self._heard, self._whereabouts.heard
        if found.si_code > 0 or (found.si_signo == signal.SIGINT and self._heard != before):
            return
        self.passed_on.add(found.si_signo)
        with suppress(ProcessLookupError):
            os.kill(self._child, found.si_signo)
        if found.si_signo == signal.SIGINT:
            self._heard = (self._heard + 1) % 256

    def _break_off_unless_it_moves(self) -> None:
        now, place = time.monotonic(), self._whereabouts.place()
        if self._asked is None or self._asked[1] != place:
            self._asked = now, place
        elif now - self._asked[0] > _STUCK_SECONDS:
            self.has_broken_off = True
            with suppress(ProcessLookupError):
                os.kill(self._child, signal.SIGKILL)
