"""Other programs' work beside what is tested: as much as the machine has processors, and more."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

EACH = 2
"""Busy processes a processor, at the priority that any program has."""
_BUSY = "while True: pass"


class Load:
    """Busy processes, that rest until they are told to begin."""

    def __init__(self) -> None:
        count = EACH * len(os.sched_getaffinity(0))
        self._processes = [
            subprocess.Popen([sys.executable, "-I", "-c", _BUSY]) for _ in range(count)
        ]
        self.rest()

    def begin(self) -> None:
        """Take what there is."""
        self._before = _idle()
        self._signal(signal.SIGCONT)

    def left(self) -> float:
        """The share of the machine's time that nobody wanted since they began."""
        idle, all_ = (now - then for now, then in zip(_idle(), self._before, strict=True))
        return idle / max(1, all_)

    def rest(self) -> None:
        """Take nothing."""
        self._signal(signal.SIGSTOP)

    def end(self) -> None:
        """Let none of them live."""
        for process in self._processes:
            process.kill()
            process.wait()

    def _signal(self, number: signal.Signals) -> None:
        for process in self._processes:
            process.send_signal(number)


def _idle() -> tuple[int, int]:
    """Ticks in which processors had nothing to do, or waited, and all ticks (proc(5))."""
    columns = [int(each) for each in Path("/proc/stat").read_text().split("\n")[0].split()[1:9]]
    return columns[3] + columns[4], sum(columns)


@contextlib.contextmanager
def load() -> Iterator[Load]:
    """For as long as a test needs them."""
    found = Load()
    try:
        yield found
    finally:
        found.end()
