"""What the machine took from the loop: time it waited for a processor, and what the host stole.

Sources: Documentation/scheduler/sched-stats.rst (run_delay of /proc/PID/schedstat), proc(5) on
/proc/stat. Where a system does not say, nothing is reported.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import Any


class Usage:
    """Measured between :meth:`begin` and :meth:`summary`, for this process; times in s."""

    def __init__(self) -> None:
        self._first: dict[str, float] = {}

    def begin(self) -> None:
        """From now on."""
        self._first = _counts()

    def summary(self) -> dict[str, Any]:
        """Seconds waited for a processor, stolen by the host, used; page faults; load."""
        if not self._first:
            return {}
        now = _counts()
        spent = {name: now[name] - before for name, before in self._first.items() if name in now}
        with contextlib.suppress(OSError):
            spent["load"] = os.getloadavg()[0]
        return {"machine": spent}


def _counts() -> dict[str, float]:
    import resource  # not on Windows

    own = resource.getrusage(resource.RUSAGE_SELF)
    found = {
        "seconds": time.monotonic(),
        "processor": own.ru_utime + own.ru_stime,
        "page_faults": float(own.ru_minflt + own.ru_majflt),
        "switched_away": float(own.ru_nivcsw),
    }
    with contextlib.suppress(OSError, ValueError, IndexError):
        delay = int(Path("/proc/self/schedstat").read_bytes().split()[1])
        found["waited"] = delay * 1e-9
    with contextlib.suppress(OSError, ValueError, IndexError):
        line = Path("/proc/stat").read_bytes().partition(b"\n")[0]
        found["stolen"] = int(line.split()[8]) / os.sysconf("SC_CLK_TCK")
    return found
