"""The command's side of a paced run: it records, listens, watches, and has the last word.

It forks the supervisor and holds a copy of every open port. Where supervisor and loop are gone, or
stand still both, nobody else can write any more: then it kills what is left of them and brings the
devices to zero itself. What it believes at the end is the shared count alone: a device whose zero
was not confirmed since its last torque is "output unknown".
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Callable, Sequence

from cosim.base.system.dying import is_dying
from cosim.base.system.pulse import RUNNING, Pulse, Who
from cosim.base.system.supervised import Supervised
from cosim.realtime.messages import Message, split

POLL_SECONDS = 0.02
DEAD_LOOP_SECONDS = 0.05
"""A supervisor that does not go on for so long, while its loop is dead, is stopped."""
STOPPED_SECONDS = 1.0
"""When neither supervisor nor loop goes on for so long, both are stopped; so is a supervisor whose
loop is dead and whose devices are at zero."""
LOCKSTEP_SECONDS = 10.0
"""In place of both, where all devices are in lock-step and no clock matters."""
LEAST_LOOKS = 3
"""Looks of this process within such a time: a machine that stood still proves nothing."""


class Watch:
    """Watches supervisor and loop by their beats, until both are gone.

    ``devices`` is how many numbers of ``pulse`` are used; not ``timed``: no clock matters to them.
    """

    def __init__(
        self, supervisor: int, pulse: Pulse, pipe: int, wake: int, devices: int, *, timed: bool
    ) -> None:
        self._devices, self._timed = devices, timed
        self._supervisor, self._pulse, self._pipe = supervisor, pulse, pipe
        self._poll = select.poll()
        for descriptor in (pipe, wake):
            self._poll.register(descriptor, select.POLLIN)
        self._wake = wake
        self._loop: int | None = None
        """A descriptor of the loop's process, readable once that is dead."""
        self._loop_dead = False
        self._still = {who: _Stillness() for who in (Who.SUPERVISOR, Who.LOOP)}
        self.killed: str | None = None
        """Why supervisor and loop had to be killed, where they had to be."""

    def to_the_end(self, take: Callable[[Message], None], now_and_then: Callable[[], None]) -> None:
        """Hand messages on until supervisor and loop write no more, neither here nor to a device.

        ``now_and_then`` is called some fifty times a second.
        """
        data = b""
        while True:
            self._pulse.beat()
            ready = {found for found, _ in self._poll.poll(POLL_SECONDS * 1e3)}
            if self._wake in ready:
                os.read(self._wake, 4096)
            if self._loop is not None and self._loop in ready:
                self._loop_dead = True
                self._poll.unregister(self._loop)
            if self._pipe in ready:
                part = os.read(self._pipe, 65536)
                messages, data = split(data + part)
                for message in messages:
                    take(message)
                if not part:
                    return
            self._look()
            if self._loop_dead and is_dying(self._supervisor) and not self._has_more():
                return
            now_and_then()

    def _has_more(self) -> bool:
        """Whether something is in the pipe still."""
        return any(found == self._pipe for found, _ in self._poll.poll(0))

    def close(self) -> None:
        """Let go of the loop's descriptor."""
        if self._loop is not None:
            os.close(self._loop)

    def _look(self) -> None:
        """Are they going on?"""
        pulse, now = self._pulse, time.monotonic()
        if self._loop is None and pulse.loop_id and hasattr(os, "pidfd_open"):
            with contextlib.suppress(OSError):
                self._loop = os.pidfd_open(pulse.loop_id)
                self._poll.register(self._loop, select.POLLIN)
        for who, still in self._still.items():
            still.look(pulse.beats(who), now)
        supervisor, loop = self._still[Who.SUPERVISOR], self._still[Who.LOOP]
        if self.killed is not None or not pulse.loop_id:
            return
        self._loop_dead = self._loop_dead or is_dying(pulse.loop_id)
        cold = all(pulse.is_cold(number) for number in range(self._devices))
        stopped = STOPPED_SECONDS if self._timed else LOCKSTEP_SECONDS
        if self._loop_dead and supervisor.lasts(
            stopped if cold or not self._timed else DEAD_LOOP_SECONDS
        ):
            self._kill("the control loop ended, and its supervisor stood still")
        elif supervisor.lasts(stopped) and loop.lasts(stopped) and pulse.loop_state == RUNNING:
            self._kill("supervisor and control loop stood still")

    def _kill(self, reason: str) -> None:
        self.killed = f"{reason}; the command killed them"
        for process in (self._pulse.loop_id, self._supervisor):
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)


class _Stillness:
    """For how long a count has stood still, by looks of this very process."""

    def __init__(self) -> None:
        self._beats, self._since, self._looks = -1, 0.0, 0

    def look(self, beats: int, now: float) -> None:
        if beats != self._beats:
            self._beats, self._since, self._looks = beats, now, 0
        self._looks += 1
        self._now = now

    def lasts(self, seconds: float) -> bool:
        return self._looks > LEAST_LOOKS and self._now - self._since > seconds


def zero_the_rest(devices: Sequence[tuple[int, Supervised]], pulse: Pulse) -> None:
    """Bring to zero what supervisor and loop have left hot; both have to be dead."""
    pulse.who = Who.COMMAND
    torn = pulse.torn()
    for number, device in devices:
        if not pulse.is_cold(number):
            device.zero_after_death(torn=torn is not None and torn[0] == number)
