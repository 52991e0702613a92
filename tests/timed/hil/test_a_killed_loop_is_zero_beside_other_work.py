"""A killed loop's motors are at zero in time, too, while other programs want every processor.

Twenty times on each board, each of which counts; with the times that it took:

    python -m pytest -m exhaustive -s tests/timed/hil -k beside_other_work
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median

import pytest

from tests.support.hil.ending_table import (
    BESIDE_WORK,
    BOARDS,
    STALL,
    Ending,
    measured,
)
from tests.support.hil.endings import Run
from tests.support.load import Load, load
from tests.support.machine import timed

TIMES = 20
ENDED = 100
"""Runs that may end by themselves, at zero, before anybody kills them: a board's answers are late
where the system's own worker, which hands bytes on, has to wait for its turn."""
LEFT = 0.05
"""The largest share of the machine that may have had nothing to do while the run ended."""


@pytest.mark.exhaustive
@pytest.mark.parametrize("how", BESIDE_WORK)
@pytest.mark.parametrize("board", BOARDS)
def test_the_motors_are_told_zero_in_time(how: str, board: str, tmp_path: Path):
    found: list[tuple[float, float]] = []
    by_themselves = 0
    with load() as others:
        try:
            while len(found) < TIMES:
                assert by_themselves <= ENDED, "its runs end by themselves"
                folder = tmp_path / f"{len(found)}_{by_themselves}"
                folder.mkdir()
                each = ended(BESIDE_WORK[how], board, folder, others)
                by_themselves += each is None
                found += [] if each is None else [each]
        finally:
            for kind, each in zip(("zero", "confirmed"), zip(*found, strict=True), strict=False):
                print(f"\n{board}: {how}: {kind} after {spread(each)}", end="")
            print(f"\n{board}: {by_themselves} runs ended by themselves before", end="")


def ended(ending: Ending, board: str, folder: Path, others: Load) -> tuple[float, float] | None:
    """Seconds to the zero and to the answer; ``None`` where the run had ended, at zero, before."""

    def attempt(number: int) -> tuple[float, float] | str | None:
        run = Run(folder / str(number), board)
        try:
            run.folder.mkdir()
            if not is_pushing(run, others):
                return at_zero_by_itself(run)
            found = measured(run, replace(ending, act=at_once(ending.act)))
            assert others.left() < LEFT, "there was not enough work beside it"
        except AssertionError as error:
            return str(error)
        else:
            return found
        finally:
            others.rest()
            be_patient()
            run.end()

    return timed(attempt, tolerates=STALL, failures=1)


def is_pushing(run: Run, others: Load) -> bool:
    """Whether the run pushes, beside the others; then this process is in a hurry."""
    try:
        run.start()
    except AssertionError:
        if run.command.poll() is None:
            raise
        return False
    others.begin()
    time.sleep(0.2)
    hurry()
    return any(run.asked("now"))


def at_zero_by_itself(run: Run) -> None:
    """A run that has ended says that it failed, and its motors are at zero."""
    be_patient()
    assert run.status() == 1, run.said
    assert not any(run.asked("now")), run.said


def at_once(act: Callable[[Run], None]) -> Callable[[Run], None]:
    """The act, and then no hurry any more."""

    def prompt(run: Run) -> None:
        act(run)
        be_patient()

    return prompt


def hurry() -> None:
    """Do not wait for a turn behind the other work: that is no time of the run's."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))
    except OSError:
        pytest.skip("no real-time priority is granted here")


def be_patient() -> None:
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def spread(seconds: tuple[float, ...]) -> str:
    each = sorted(1e3 * second for second in seconds)
    ninth = each[min(len(each) - 1, round(0.9 * len(each)))]
    return (
        f"{each[0]:.1f} to {each[-1]:.1f} ms, median {median(each):.1f}, nine in ten {ninth:.1f}"
        f" (n = {len(each)})"
    )
