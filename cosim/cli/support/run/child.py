"""A simulation in a child process: whatever an FMU does to it, there are a sentence and a status.

The parent waits. A run has succeeded when the child has said that it is over, never because a
process ended with status 0: an FMU may call ``exit(0)``.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import select
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from cosim.base.errors import CohapticError
from cosim.cli.support.run.left_behind import conclude_run, give_up
from cosim.cli.support.run.signals import HEARD, Post
from cosim.master.run.execution.loop import Progress
from cosim.master.run.whereabouts import Whereabouts
from cosim.preparation.prepare import Judge
from cosim.run import Execute, Finished, run_scenario
from cosim.scenario import Scenario

_POLL_SECONDS = 0.05
_PR_SET_PDEATHSIG = 1


def run_in_child(
    scenario: Scenario,
    out: Path | None,
    *,
    progress: Progress | None,
    figure: bool,
    page: bool | None,
    judge: Judge,
    say: Callable[[str], None],
    execute: Execute | None = None,
) -> Finished:
    """``run_scenario`` in a process of its own, with the same result and the same errors.

    In this process where the system has no ``fork`` and no ``sigtimedwait`` (Linux has both).

    Raises:
        InputError, RunError: as ``run_scenario``; ``RunError`` too where the child died before
            there was a record.
        KeyboardInterrupt: Ctrl-C before there was anything to keep.
    """
    if not hasattr(os, "fork") or not hasattr(signal, "sigtimedwait"):
        return run_scenario(
            scenario,
            out,
            progress=progress,
            execute=execute,
            figure=figure,
            page=page,
            judge=judge,
            say=say,
        )
    whereabouts = Whereabouts()
    ear, mouth = os.pipe()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    # Blocked, so that the parent can ask where a signal came from (see ``Post``).
    before = signal.pthread_sigmask(signal.SIG_BLOCK, HEARD)
    try:
        parent = os.getpid()
        child = os.fork()
        if child == 0:
            os.close(ear)
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
            _be_the_child(
                _Teller(mouth, whereabouts),
                parent,
                lambda teller: run_scenario(
                    scenario,
                    out,
                    progress=teller.progress if progress is not None else None,
                    execute=execute,
                    figure=figure,
                    page=page,
                    judge=judge,
                    say=say,
                    watcher=teller,
                ),
            )
        os.close(mouth)
        told = _Told(ear)
        post = Post(child, whereabouts)
        try:
            status = _listen(child, told, progress, post)
        except BaseException:
            os.kill(child, signal.SIGTERM)
            os.waitpid(child, 0)
            raise
    finally:
        os.close(ear)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    if signal.SIGTERM in post.passed_on and status == -signal.SIGTERM:
        os.kill(os.getpid(), signal.SIGTERM)  # the end that was asked of this process
    if post.has_broken_off:
        return give_up(told.content, whereabouts, scenario)
    return conclude_run(told.content, status, whereabouts, scenario)


class _Teller:
    """In the child: tells the parent how far the run is."""

    def __init__(self, pipe: int, whereabouts: Whereabouts) -> None:
        self.whereabouts = whereabouts
        self._pipe = pipe

    def progress(self, ticks: int, wall_time: float) -> None:
        self.tell("progress", (ticks, wall_time))

    def begun(self, folder: Path) -> None:
        self.tell("begun", folder)

    def finished(self, finished: Finished) -> None:
        self.tell("finished", finished)

    def tell(self, what: str, content: Any) -> None:
        data = pickle.dumps((what, content))
        frame = len(data).to_bytes(8, "little") + data
        with suppress(BrokenPipeError):
            while frame:
                frame = frame[os.write(self._pipe, frame) :]


def _be_the_child(teller: _Teller, parent: int, run: Callable[[_Teller], object]) -> None:
    """Run, tell, and end without what an FMU may have left for the end of the process."""
    status = 1
    try:
        _die_with(parent)
        run(teller)
        teller.tell("over", None)
        status = 0
    except CohapticError as error:
        teller.tell("error", error)
    except KeyboardInterrupt:
        teller.tell("interrupted", None)
    except SystemExit as stop:
        teller.tell("left", str(stop.code))
    except BaseException:
        teller.tell("bug", traceback.format_exc())
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        ctypes.CDLL(None).fflush(None)  # what FMUs printed
        os._exit(status)


def _die_with(parent: int) -> None:
    """On Linux the child of a parent that was killed is ended, too."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
        if os.getppid() != parent:
            os.kill(os.getpid(), signal.SIGTERM)


class _Told:
    """In the parent: what the child has said."""

    def __init__(self, pipe: int) -> None:
        self.content: dict[str, Any] = {}
        self.pipe, self._rest = pipe, b""

    def read(self) -> bool:
        """Take what is there; whether more may come."""
        part = os.read(self.pipe, 65536)
        self._rest += part
        while len(self._rest) >= 8:
            end = 8 + int.from_bytes(self._rest[:8], "little")
            if len(self._rest) < end:
                break
            what, content = pickle.loads(self._rest[8:end])  # from our own child
            self.content[what] = content
            self._rest = self._rest[end:]
        return bool(part)


def _listen(child: int, told: _Told, progress: Progress | None, post: Post) -> int:
    """Until the child has ended: its status, negative after a signal.

    The end is the child's, not the pipe's: processes that an FMU has started may hold that.
    """
    is_open = True
    while True:
        ended, raw = os.waitpid(child, os.WNOHANG)
        while is_open and select.select([told.pipe], [], [], 0 if ended else _POLL_SECONDS)[0]:
            is_open = told.read()
            if progress is not None and (shown := told.content.pop("progress", None)):
                progress(*shown)
            if not ended:
                break
        if ended:
            return os.waitstatus_to_exitcode(raw)
        post.pass_on(0 if is_open else _POLL_SECONDS)
