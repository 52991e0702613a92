"""Making a process keep deadlines, and saying plainly what the system would not allow.

Sources: clock_nanosleep(2), sched_setscheduler(2), mlockall(2), setrlimit(2); the Linux real-time
documentation on throttling. Nothing in here fails: a refusal is a sentence, and the loop runs on,
milliseconds late where there is no real-time scheduling.
"""

from __future__ import annotations

import ctypes
import errno
import gc
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Literal

from cosim.errors import RunError
from hil.deadlines import Deadlines
from hil.pulse import RUNNING, Pulse

LOOP_PRIORITY = 70
SUPERVISOR_PRIORITY = 75
"""Above the loop, so that a loop that runs away cannot keep its supervisor from acting."""
LONGEST_BURST = 0.1
"""CPU time without a pause (s) after which the kernel kills a real-time loop."""
LONGEST_SPIN = 100e-6
"""Nobody busy-waits longer than this before a deadline (s)."""

Policy = Literal["count", "stop"]
_MONOTONIC, _ABSOLUTE = 1, 1
_CURRENT_AND_FUTURE = 3


@dataclass(frozen=True, slots=True)
class Grant:
    """One thing that was asked of the system; ``sentence`` says how to get it where it was not."""

    name: str
    granted: bool
    sentence: str


def prepare_loop(*, priority: int = LOOP_PRIORITY, cpu: int | None = None) -> list[Grant]:
    """Everything for the loop's process, in the order in which it has to be done."""
    return [
        freeze_garbage(),
        lock_memory(),
        pin(cpu),
        limit_burst(),
        real_time_priority(priority),
    ]


def freeze_garbage() -> Grant:
    """Take everything that exists out of garbage collection, and collect nothing from now on."""
    gc.collect()
    gc.freeze()
    gc.disable()
    return Grant("garbage", True, "garbage collection is frozen")


def lock_memory() -> Grant:
    """Keep every page in memory."""
    libc = _libc()
    if libc is None:
        return Grant("memory", False, "memory is not locked: this system has no mlockall")
    if libc.mlockall(_CURRENT_AND_FUTURE) == 0:
        return Grant("memory", True, "all memory is locked")
    return Grant(
        "memory",
        False,
        f"memory is not locked ({os.strerror(ctypes.get_errno())}): a page fault may delay a tick; "
        "raise the limit with 'ulimit -l unlimited' or memlock in /etc/security/limits.conf",
    )


def pin(cpu: int | None = None) -> Grant:
    """Stay on one processor, the last allowed one by default; never on the only one."""
    if not hasattr(os, "sched_getaffinity"):
        return Grant("processor", False, "the loop is not pinned: this system cannot do it")
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        return Grant("processor", False, "the loop is not pinned: there is one processor only")
    chosen = allowed[-1] if cpu is None else cpu
    if chosen not in allowed:
        return Grant("processor", False, f"the loop is not pinned: processor {chosen} is not ours")
    os.sched_setaffinity(0, {chosen})
    return Grant("processor", True, f"the loop is pinned to processor {chosen}")


def limit_burst(seconds: float = LONGEST_BURST) -> Grant:
    """Have the kernel kill a real-time loop that never sleeps (RLIMIT_RTTIME)."""
    if sys.platform != "linux":
        return Grant("burst", False, "a runaway loop is not limited: RLIMIT_RTTIME is Linux only")
    import resource

    # typeshed does not know RLIMIT_RTTIME; 15 is its number on every Linux.
    number = int(getattr(resource, "RLIMIT_RTTIME", 15))
    wanted = round(seconds * 1e6)
    try:
        resource.setrlimit(number, (wanted, wanted))
    except (OSError, ValueError) as error:
        return Grant("burst", False, f"a runaway loop is not limited: {error}")
    return Grant("burst", True, f"a loop that runs {seconds * 1e3:.0f} ms on end is killed")


def real_time_priority(priority: int) -> Grant:
    """SCHED_FIFO."""
    if not hasattr(os, "sched_setscheduler"):
        return Grant("priority", False, "no real-time priority: this system has no SCHED_FIFO")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        return Grant(
            "priority",
            False,
            "no real-time priority: ticks will be milliseconds late; grant it with "
            f"'ulimit -r {priority}', rtprio in /etc/security/limits.conf, or CAP_SYS_NICE",
        )
    except OSError as error:
        return Grant("priority", False, f"no real-time priority: {error}")
    return Grant("priority", True, f"SCHED_FIFO priority {priority}")


def clock_nanosleep() -> Callable[[int], None]:
    """A function that sleeps until an absolute CLOCK_MONOTONIC time (ns)."""
    libc = _libc()
    if libc is None or not hasattr(libc, "clock_nanosleep"):
        return _sleep_until
    call = libc.clock_nanosleep

    def sleep(until: int) -> None:
        wanted = _Timespec(until // 1_000_000_000, until % 1_000_000_000)
        while call(_MONOTONIC, _ABSOLUTE, ctypes.byref(wanted), None) == errno.EINTR:
            pass

    return sleep


@dataclass(slots=True, kw_only=True)
class RealtimePacer:
    """The master's pacer for a loop on hardware: absolute deadlines, contiguous ticks, no bursts.

    A tick is late when it starts a whole period or more after its deadline; then the grid of
    deadlines moves by whole periods, so that nothing is caught up. ``spin`` (s) busy-waits the
    last stretch; ``stopping`` is asked every tick.
    """

    tick_seconds: Fraction
    policy: Policy = "count"
    spin: float = 0.0
    pulse: Pulse | None = None
    stopping: Callable[[], bool] | None = None
    deadlines: Deadlines = field(default_factory=Deadlines)
    clock: Callable[[], int] = time.monotonic_ns
    sleep: Callable[[int], None] = field(default_factory=clock_nanosleep)
    _origin: int = 0
    _first: int = 0

    def start(self, tick: int) -> None:
        """Tick ``tick`` is due now."""
        self._origin, self._first = self.clock(), tick
        if self.pulse is not None:
            self.pulse.beat()
            self.pulse.state(RUNNING)

    def wait(self, tick: int) -> None:
        """Return at the deadline of ``tick``.

        Raises:
            RunError: it was missed and the policy is ``stop``.
            KeyboardInterrupt: the run was asked to stop; every signal ends between two ticks.
        """
        if self.stopping is not None and self.stopping():
            raise KeyboardInterrupt
        due = self._due(tick)
        early = round(min(self.spin, LONGEST_SPIN) * 1e9)
        if self.clock() < due - early:
            self.sleep(due - early)
        now = self.clock()
        while now < due:
            now = self.clock()
        if self.pulse is not None:
            self.pulse.beat()
        late = now - due
        self.deadlines.add(late)
        periods = int(late * Fraction(1, 1_000_000_000) / self.tick_seconds)
        if periods:
            self._missed(tick, late, periods)

    def _missed(self, tick: int, late: int, periods: int) -> None:
        self.deadlines.misses += 1
        self.deadlines.slipped += periods
        if self.policy == "stop":
            raise RunError(
                f"tick {tick} began {late * 1e-6:.3g} ms after its deadline; the policy is to stop "
                "(policy 'count' goes on)"
            )

    def _due(self, tick: int) -> int:
        # The numerator times 10^9 first: 1/1024 s is no whole number of nanoseconds.
        periods = tick - self._first + self.deadlines.slipped
        step = self.tick_seconds
        return self._origin + periods * step.numerator * 1_000_000_000 // step.denominator


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


def _libc() -> Any:
    if sys.platform == "win32":
        return None
    library = ctypes.CDLL(None, use_errno=True)
    return library if hasattr(library, "mlockall") else None


def _sleep_until(until: int) -> None:
    time.sleep(max(0, until - time.monotonic_ns()) * 1e-9)
