"""Whether the machine kept time, said by a process that has nothing to do with what is tested.

A timed test may be void only where this probe, which ran beside it at the loops' own priority, was
late itself. What fails while the probe was on time has failed.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Protocol, TypeVar

import pytest

Result = TypeVar("Result")

FAULTS = 3
"""Failures with a machine that kept time; then the test fails."""
ATTEMPTS = 8
"""Attempts altogether, those included that the probe declared void."""

_PROBE = """
import os, select, sys, time
try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(70))
except (AttributeError, OSError):
    pass
sys.stdout.write("ready\\n")
sys.stdout.flush()
worst, at = 0.0, time.monotonic()
while True:
    at += 0.001
    time.sleep(max(0.0, at - time.monotonic()))
    now = time.monotonic()
    worst = max(worst, now - at)
    at = max(at, now - 0.001)
    if select.select([sys.stdin], [], [], 0)[0]:
        if not sys.stdin.readline():
            break
        sys.stdout.write(f"{worst}\\n")
        sys.stdout.flush()
        worst, at = 0.0, time.monotonic()
"""


class Probe(Protocol):
    """Whoever judges the machine, and not what is timed on it."""

    def worst(self) -> float:
        """What it found since the last question."""
        ...

    def tell(self, worst: float) -> str:
        """The same for people."""
        ...


class MachineProbe:
    """A process that wakes a thousand times a second and notes how late it was."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-c", _PROBE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"

    def worst(self) -> float:
        """The latest that it woke (s) since the last question."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write("worst\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        assert self._process.stdin is not None
        self._process.communicate()

    @staticmethod
    def tell(worst: float) -> str:
        """What was found, for people."""
        return f"a probe beside it was {worst * 1e3:.0f} ms late"


@contextlib.contextmanager
def machine_probe() -> Iterator[MachineProbe]:
    """A probe beside what is timed."""
    probe = MachineProbe()
    try:
        yield probe
    finally:
        probe.close()


def timed(
    attempt: Callable[[int], Result | str],
    *,
    tolerates: float,
    attempts: int = ATTEMPTS,
    failures: int = FAULTS,
    probing: Callable[[], AbstractContextManager[Probe]] = machine_probe,
) -> Result:
    """What the first good attempt gives; an attempt that failed gives a sentence instead.

    ``attempt`` takes its number. A failed one is void where the probe found more than ``tolerates``
    meanwhile (of ``machine_probe`` seconds); of those that are not void, the last that ``failures``
    allows fails the test. A machine that spoiled so many attempts that there never were as many
    leaves the test void, with the probe's figures.
    """
    faults: list[str] = []
    stalls: list[float] = []
    with probing() as probe:
        for number in range(attempts):
            probe.worst()
            found = attempt(number)
            if not isinstance(found, str):
                return found
            worst = probe.worst()
            if worst > tolerates:
                stalls.append(worst)
                continue
            faults.append(found)
            if len(faults) == failures:
                times = "once" if failures == 1 else f"{failures} times"
                pytest.fail(f"the machine kept time and it failed {times}: {faults}")
    told = "; ".join(map(probe.tell, stalls))
    others = f"; beside that: {faults}" if faults else ""
    pytest.skip(f"void: {told}; more than {tolerates:g}{others}")
