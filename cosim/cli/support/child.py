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
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from cosim.base.errors import CohapticError, RunError
from cosim.master.run.execution.loop import Progress
from cosim.master.run.obituary import COMPLETE, KEPT, NOTHING, obituary
from cosim.master.run.whereabouts import Whereabouts
from cosim.preparation.prepare import Judge
from cosim.record.manifest import conclude, write_json, write_manifest
from cosim.record.reader import RUN_FILE, open_run
from cosim.record.rewriting.compact import compact
from cosim.report.expectation import parse_expectations
from cosim.report.summary import SUMMARY_FILE, Summary, summarise
from cosim.run import LOG_FILE, Execute, Finished, run_scenario, write_log
from cosim.scenario import Scenario

_HEARD = {signal.SIGINT, signal.SIGTERM}
_POLL_SECONDS = 0.05
_HEARING_SECONDS = 0.15
"""A run hears an interrupt within a chunk of ticks, some 50 ms."""
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
    # Blocked, so that the parent can ask where a signal came from (see ``_Post``).
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _HEARD)
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
        post = _Post(child, whereabouts)
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
    return _judge(told, status, whereabouts, scenario)


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


def _listen(child: int, told: _Told, progress: Progress | None, post: _Post) -> int:
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


class _Post:
    """Hands on signals that were sent to the parent alone.

    Ctrl-C reaches every process of the terminal's group by itself, from the kernel, and some send
    to a group: heard twice, it would be taken for the second one, which breaks off at once.
    """

    def __init__(self, child: int, whereabouts: Whereabouts) -> None:
        self.passed_on: set[int] = set()
        self._child, self._whereabouts, self._heard = child, whereabouts, 0

    def pass_on(self, seconds: float) -> None:
        """Wait so long for a signal."""
        found = signal.sigtimedwait(_HEARD, seconds)
        if found is None:
            return
        if found.si_signo == signal.SIGINT:
            time.sleep(_HEARING_SECONDS)
        before, self._heard = self._heard, self._whereabouts.heard
        if found.si_code > 0 or (found.si_signo == signal.SIGINT and self._heard != before):
            return
        self.passed_on.add(found.si_signo)
        with suppress(ProcessLookupError):
            os.kill(self._child, found.si_signo)
        if found.si_signo == signal.SIGINT:
            self._heard = (self._heard + 1) % 256


def _keep_logs(folder: Path, whereabouts: Whereabouts, scenario: Scenario) -> None:
    """What FMUs had logged when their process died, where the run has not written it itself."""
    said = whereabouts.said(scenario)
    if said and not (folder / LOG_FILE).exists():
        write_log(folder / LOG_FILE, said)


def _judge(told: _Told, status: int, whereabouts: Whereabouts, scenario: Scenario) -> Finished:
    content = told.content
    if "error" in content:
        if "finished" in content:  # an isolated FMU whose process died when it was closed
            sentence = f"{content['error']}; {COMPLETE}."
            return _finish_for(content["begun"], scenario, sentence, whereabouts)
        raise content["error"]
    if "interrupted" in content:
        raise KeyboardInterrupt
    if "bug" in content:
        raise RuntimeError(f"in the run's process:\n{content['bug']}")
    if "over" in content and status == 0:
        return content["finished"]
    sentence = obituary(status, whereabouts, scenario, content.get("left"))
    if "begun" not in content:
        raise RunError(f"{sentence}; {NOTHING}.")
    kept = COMPLETE if "finished" in content else KEPT
    return _finish_for(content["begun"], scenario, f"{sentence}; {kept}.", whereabouts)


def _finish_for(
    folder: Path, scenario: Scenario, message: str, whereabouts: Whereabouts
) -> Finished:
    """Finish the record in ``folder`` of a run whose process has died, and say so in it.

    What was flushed before is there; what had been finished stays, but the run has failed.
    """
    with suppress(OSError):
        compact(folder / RUN_FILE)
    with suppress(OSError):
        _keep_logs(folder, whereabouts, scenario)
    with open_run(folder) as run:
        manifest = dict(run.manifest)
        if manifest.get("exit") is None:
            conclude(manifest, status=1, message=message, ticks=whereabouts.kernel.tick)
        else:
            manifest["exit"] = {**manifest["exit"], "status": 1, "message": message}
        write_manifest(folder, manifest)
        run.manifest = manifest
        units = {
            signal.column.name: signal.column.unit or ""
            for group in run.groups.values()
            for signal in group.signals.values()
        }
        content = dict(summarise(run, parse_expectations(scenario, units)).content)
    write_json(folder / SUMMARY_FILE, content)
    return Finished(folder, Summary(content), RunError(message))
