"""How much of the processors others took: for what is timed and takes a good part of them itself.

A probe that asks for a share of its own (``tests.support.machine``) is late because of a browser,
too, and so would let off a page that has become slow. Here only those count that are no
descendants of the test.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")
Process = tuple[int, int]
"""Its number, and when it began."""
STOLEN = 8
"""The column of ``/proc/stat`` that has what other machines on the same processors took."""


class OthersProbe:
    """Sums the processor time of all processes but the test's own, and what was stolen."""

    def __init__(self) -> None:
        self._own: set[Process] = set()
        self._at, self._before = time.monotonic(), sum(of_others(self._own).values())

    def worst(self) -> float:
        """Processors that others took since the last question, on average."""
        now, after = time.monotonic(), sum(of_others(self._own).values())
        passed, self._at = now - self._at, now
        before, self._before = self._before, after
        return max(0, after - before) / TICKS / passed

    @staticmethod
    def tell(worst: float) -> str:
        """What was found, for people."""
        return f"others took {worst:.2f} processors"


@contextlib.contextmanager
def others_probe() -> Iterator[OthersProbe]:
    """A probe of what others take."""
    yield OthersProbe()


def of_others(own: set[Process]) -> dict[Process, int]:
    """Clock ticks that each process has used, with its children that ended; 0 is what was stolen.

    Their sum grows by what is used, since the use of a process that ends passes to its parent.
    ``own`` takes the test's own ones, which stay its own when they have lost their parents.
    """
    parents: dict[int, int] = {}
    used: dict[Process, int] = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            # A name may hold anything; what follows it does not.
            fields = file.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
            number = int(file.parent.name)
            parents[number] = int(fields[1])
            used[number, int(fields[19])] = sum(map(int, fields[11:15]))
    own.update(process for process in used if _descends(process[0], os.getpid(), parents))
    stolen = int(Path("/proc/stat").read_text(encoding="utf-8").split()[STOLEN])
    return {(0, 0): stolen} | {
        process: ticks for process, ticks in used.items() if process not in own
    }


def _descends(number: int, ancestor: int, parents: dict[int, int]) -> bool:
    while number != ancestor:
        number = parents.get(number, 0)
        if number == 0:
            return False
    return True
