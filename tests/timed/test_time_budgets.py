"""What the project promises about time, measured by its own benches.

A limit is missed only where the machine kept time beside it, three times. It has to be idle.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.machine import timed

BENCH = Path(__file__).parents[2] / "bench"
pytestmark = pytest.mark.slow

STALL = 0.02
"""Lateness (s) of the probe from which an attempt says nothing."""


def figure(pattern: str, bench: str, *arguments: str) -> float:
    """The number that ``pattern`` finds in what a bench prints."""
    command = [sys.executable, str(BENCH / bench), *arguments]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = re.search(pattern, said)
    assert found is not None, said
    return float(found[1])


@pytest.mark.parametrize(
    ("what", "limit", "pattern", "command"),
    [
        (
            "ms to the first tick of two_users_box, the least of five",
            450,
            r"total +([\d.]+)",
            ("start_up.py", "two_users_box", "--processes", "5"),
        ),
        (
            "s to load, assemble and start a ring of 4,096",
            4.0,
            r"4096.*s +([\d.]+)s +[\d.]* *\d+\n",
            ("assembly.py", "--sizes", "4096", "--rounds", "2"),
        ),
        (
            "times the bare C loop, nothing recorded",
            1.06,
            r"median ratio, recording off: ([\d.]+)",
            ("kernel.py", "two_users_box"),
        ),
        (
            "times the bare C loop over a ring of eight light FMUs, nothing recorded",
            1.3,
            r"median ratio, recording off: ([\d.]+)",
            ("kernel.py", "ring:8", "--seconds", "60", "--rounds", "7"),
        ),
        (
            "times the bare C loop over that ring, everything recorded, both with a binary log",
            1.1,
            r"median ratio, recording on, to a binary log: ([\d.]+)",
            ("kernel.py", "ring:8", "--seconds", "60", "--rounds", "7"),
        ),
        (
            "times the bare C loop, everything recorded",
            1.4,
            r"median ratio, recording on: ([\d.]+)",
            ("kernel.py", "two_users_box"),
        ),
    ],
)
def test_a_budget_is_kept(what: str, limit: float, pattern: str, command: tuple[str, ...]) -> None:
    def attempt(_: int) -> str | float:
        found = figure(pattern, *command)
        return found if found <= limit else f"{found:g} {what}, more than {limit:g}"

    print(timed(attempt, tolerates=STALL), what)


def test_nothing_is_slower_or_larger_than_in_the_last_release() -> None:
    """Ratios of processor time and of memory, which say the same on a busy machine."""

    def attempt(_: int) -> str | float:
        command = [sys.executable, str(BENCH / "ratios.py")]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        return (done.stderr or done.stdout) if done.returncode else 0.0

    print(timed(attempt, tolerates=STALL), "is the status of bench/ratios.py")
