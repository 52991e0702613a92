"""Whether this machine can fall asleep, keeping it awake, and noticing that it was asleep.

A machine that sleeps stops every process, and a board without a watchdog goes on pushing. Waking up
shows in the clocks (CLOCK_BOOTTIME goes on meanwhile, CLOCK_MONOTONIC does not), but only
afterwards. A virtual machine that is paused from outside shows in neither.
Sources: clock_gettime(2); systemd-inhibit(1); Linux, Documentation/admin-guide/pm/sleep-states.rst.
"""

from __future__ import annotations

import select
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

LONGEST_STEP = 0.001
"""A difference of the clocks that grows by more than this (s) was a sleep."""
GRANT_SECONDS = 5.0
"""How long the system's service may take to grant that it stays awake."""
_STATES = Path("/sys/power/state")
_INHIBIT = (
    *("systemd-inhibit", "--what=sleep:idle:handle-lid-switch", "--mode=block"),
    *("--who=cohaptic", "--why=a haptic device is in use", "sh", "-c", "echo held; exec cat"),
)


class SleepWatch:
    """Notices that the machine has slept since the last look."""

    def __init__(
        self,
        going: Callable[[], float] = time.monotonic,
        all_along: Callable[[], float] | None = None,
    ) -> None:
        """``going`` stands still in sleep, ``all_along`` does not (s)."""
        self._going = going
        self._all_along = all_along or _boot_time
        self._most: float | None = None
        """What the clocks differ by at most, while the machine is awake (s)."""

    def slept(self) -> float:
        """How long the machine has slept at least since the last look (s), 0 where it has not."""
        before, all_along, after = self._going(), self._all_along(), self._going()
        if self._most is None:
            self._most = all_along - before
            return 0.0
        step = all_along - after - self._most
        if step > LONGEST_STEP:
            self._most = all_along - before
            return step
        self._most = min(self._most, all_along - before)
        return 0.0


def _boot_time() -> float:
    clock = getattr(time, "CLOCK_BOOTTIME", None)
    return time.monotonic() if clock is None else time.clock_gettime(clock)


def can_sleep(states: Path = _STATES) -> bool:
    """Whether the kernel offers any state of sleep."""
    try:
        return bool(states.read_text("ascii").strip())
    except OSError:
        return False


class Wakefulness:
    """Keeps the machine awake until it is let go of, and every process forked meanwhile is gone."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def keep(
        self,
        *,
        states: Path = _STATES,
        command: Sequence[str] = _INHIBIT,
        wait: float = GRANT_SECONDS,
    ) -> str | None:
        """Why it cannot be kept awake, ``None`` where it is, or never sleeps."""
        if self._process is not None or not can_sleep(states):
            return None
        try:
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except OSError as error:
            return f"{command[0]}: {error.strerror}"
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], wait)
        if ready and process.stdout.readline() == b"held\n":
            self._process = process
            return None
        _end(process)
        return f"{command[0]} does not grant it"

    def let_go(self) -> None:
        """The machine may sleep again."""
        if self._process is not None:
            _end(self._process)
            self._process = None


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    process.communicate()
