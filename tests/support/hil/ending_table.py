"""Every way to end a paced run, and what the motors must have been told by when.

docs/safety.md shows the table; the system's tests go through it once, the timed ones ten times.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from hil.safety.limits import Limits
from tests.support.hil.endings import Run
from tests.support.machine import timed

TICK = 1 / 1024
BOARDS = ("haply", "cobs", "odrive", "canopen", "cia402")
ANSWER = 0.03
"""What the answer that confirms a zero may take beyond it (s): an ODrive speaks every 10 ms."""
STALL = 0.003
"""A machine that stood still for longer (s) ends a run by itself: a Haply may miss three ticks."""


def kill(*numbers: Callable[[Run], int], how: signal.Signals = signal.SIGKILL):
    """Send a signal to processes of the run, all of them found first."""

    def act(run: Run) -> None:
        found = [number(run) for number in numbers]
        for process in found:
            os.kill(process, how)

    return act


def command(run: Run) -> int:
    return run.command.pid


def supervisor(run: Run) -> int:
    return run.supervisor


def loop(run: Run) -> int:
    return run.loop


def groups(*numbers: Callable[[Run], int]):
    def act(run: Run) -> None:
        found = [number(run) for number in numbers]
        for process in found:
            os.killpg(process, signal.SIGKILL)

    return act


def stop_then_kill_the_loop(run: Run) -> None:
    found = run.loop
    os.kill(run.supervisor, signal.SIGSTOP)
    os.kill(found, signal.SIGKILL)


def storm(run: Run) -> None:
    """Signals that go on coming while the devices are being zeroed."""
    processes = (run.command.pid, run.supervisor, run.loop)
    for number in range(400):
        for process in processes:
            try:
                os.kill(process, (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1)[number % 3])
            except ProcessLookupError:
                return
        time.sleep(0.0005)


@dataclass(frozen=True)
class Ending:
    act: Callable[[Run], None]
    within: float
    """Seconds to a zero that lasts."""
    alive: bool = True
    """Whether the command lives to say how it ended."""


ENDINGS = {
    "Ctrl-C": Ending(lambda run: run.type("\x03"), 0.05),
    "Ctrl-\\": Ending(lambda run: run.type("\x1c"), 0.05),
    "Ctrl-Z": Ending(lambda run: run.type("\x1a"), 0.05),
    "terminal closed": Ending(Run.close_terminal, 0.05),
    "SIGHUP": Ending(kill(command, how=signal.SIGHUP), 0.05),
    "SIGTERM": Ending(kill(command, how=signal.SIGTERM), 0.05),
    "SIGUSR1": Ending(kill(command, how=signal.SIGUSR1), 0.05),
    "SIGALRM": Ending(kill(command, how=signal.SIGALRM), 0.05),
    "SIGTTOU": Ending(kill(command, how=signal.SIGTTOU), 0.05),
    "SIGTERM to the supervisor": Ending(kill(supervisor, how=signal.SIGTERM), 0.05),
    "SIGTERM to the loop": Ending(kill(loop, how=signal.SIGTERM), 0.05),
    "1,200 signals while zeroing": Ending(storm, 0.05),
    "command killed": Ending(kill(command), 0.05, alive=False),
    "supervisor killed": Ending(kill(supervisor), 0.05),
    "loop killed": Ending(kill(loop), 0.05),
    "the command's group killed": Ending(groups(command), 0.05, alive=False),
    "the supervisor's group killed": Ending(groups(supervisor), 0.05),
    "the loop's group killed": Ending(groups(loop), 0.05),
    "supervisor and loop killed": Ending(kill(supervisor, loop), 0.05),
    "command and loop killed": Ending(kill(command, loop), 0.05, alive=False),
    "loop stopped": Ending(kill(loop, how=signal.SIGSTOP), 0.06),
    "supervisor stopped": Ending(kill(supervisor, how=signal.SIGSTOP), 0.35),
    "supervisor stopped, loop killed": Ending(stop_then_kill_the_loop, 0.15),
    "supervisor and loop stopped": Ending(kill(supervisor, loop, how=signal.SIGSTOP), 1.3),
    "command stopped": Ending(kill(command, how=signal.SIGSTOP), 2.3, alive=False),
}

BESIDE_WORK = {"loop killed": Ending(kill(loop), 0.1)}
"""What is promised while other programs of normal priority want every processor. What goes through
a serial port, or a pseudo-terminal, is handed on by a worker of the system of that priority."""


@contextmanager
def pushing(folder: Path, board: str) -> Iterator[Run]:
    """A run that pushes, in a new folder.

    Raises:
        AssertionError: it does not come to that.
    """
    made = Run(folder, board)
    try:
        folder.mkdir()
        made.start()
        yield made
    finally:
        made.end()


def end_it(how: str, board: str, folder: Path) -> None:
    """End a run that pushes.

    Raises:
        AssertionError: it did not end as the table says, though the machine kept time.
    """

    def attempt(number: int) -> tuple[float, float] | str:
        try:
            with pushing(folder / str(number), board) as run:
                return measured(run, ENDINGS[how])
        except AssertionError as error:
            return str(error)

    zero, answer = timed(attempt, tolerates=STALL)
    print(f"{board}: {how}: zero after {zero * 1e3:.1f} ms, confirmed after {answer * 1e3:.1f} ms")


def measured(run: Run, ending: Ending) -> tuple[float, float]:
    """Seconds to the zero on the wire, and to the answer that confirms it.

    Everything else about the ending is asserted.
    """
    at = time.monotonic()
    ending.act(run)
    status = run.status() if ending.alive else None
    time.sleep(max(0.3, at + ending.within + 0.3 - time.monotonic()))
    seen = run.seen()
    check_every_tick(seen.torques)
    assert seen.pushes(at), f"it had stopped pushing before: {run.said}"
    found = seen.first_zero(at)
    assert found is not None, f"the motors were never told zero: {run.said}"
    assert found < ending.within + seen.busy(at, found), f"{found:.3f} s: {run.said}"
    answer = seen.first_answer(at)
    assert answer is not None, f"the motors never said that they are at zero: {run.said}"
    assert answer < ending.within + ANSWER + seen.busy(at, answer), f"{answer:.3f} s: {run.said}"
    if status is not None:
        assert status == 1, run.said
        assert "output unknown" not in run.said, run.said
    return found, answer


def check_every_tick(torques: list[tuple[float, float, float]]) -> None:
    """No torque beyond the limit; none that grows faster than the slew."""
    step = Limits().slew * TICK
    for (_, *before), (_, *now) in pairwise(torques):
        for was, is_ in zip(before, now, strict=True):
            assert abs(is_) <= Limits().torque
            carried = abs(was) if was * is_ > 0 else 0.0
            assert abs(is_) <= carried + step + 1e-6
