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
from dataclasses import dataclass
from typing import Any

from cosim.base.system.processors import claim

LOOP_PRIORITY = 70
SUPERVISOR_PRIORITY = 75
"""Above the loop, so that a loop that runs away cannot keep its supervisor from acting."""
LONGEST_BURST = 0.1
"""CPU time without a pause (s) after which the kernel kills a real-time loop."""

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
    """Stay on one processor; never on the only one.

    By default it is the least used one that no other loop of ours has claimed.
    """
    if not hasattr(os, "sched_getaffinity"):
        return Grant("processor", False, "the loop is not pinned: this system cannot do it")
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        return Grant("processor", False, "the loop is not pinned: there is one processor only")
    if cpu is not None and cpu not in allowed:
        return Grant("processor", False, f"the loop is not pinned: processor {cpu} is not ours")
    chosen = claim(allowed if cpu is None else [cpu])
    if chosen is None and cpu is None:
        return Grant("processor", False, "the loop is not pinned: every processor has a loop")
    chosen = cpu if chosen is None else chosen
    assert chosen is not None
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


def end_priority() -> None:
    """From here on as any other process: what comes behind the last tick has no deadline."""
    if hasattr(os, "sched_setscheduler"):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def clock_nanosleep() -> Callable[[int], None]:
    """A function that sleeps until an absolute CLOCK_MONOTONIC time (ns)."""
    libc = _libc()
    if libc is None or not hasattr(libc, "clock_nanosleep"):
        return _sleep_until
    call = libc.clock_nanosleep

    wanted = _Timespec()
    where = ctypes.byref(wanted)

    def sleep(until: int) -> None:
        wanted.seconds, wanted.nanoseconds = divmod(until, 1_000_000_000)
        while call(_MONOTONIC, _ABSOLUTE, where, None) == errno.EINTR:
            pass

    return sleep


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


def _libc() -> Any:
    if sys.platform == "win32":
        return None
    library = ctypes.CDLL(None, use_errno=True)
    return library if hasattr(library, "mlockall") else None


def _sleep_until(until: int) -> None:
    time.sleep(max(0, until - time.monotonic_ns()) * 1e-9)
