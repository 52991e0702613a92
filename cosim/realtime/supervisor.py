"""The process that outlives the control loop, and brings to zero what the loop leaves.

It forks the loop, which inherits the open ports; it watches the loop's beats; and when the loop is
gone or stands still, it kills it, completes or drains the frame that was under way, sends zero
until an answer confirms it, and reaps the loop. It has a session of its own, so that no terminal
and no group of processes takes it along, and it keeps every signal blocked. Linux and macOS.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from cosim.base.system.dying import is_dying
from cosim.base.system.grants import SUPERVISOR_PRIORITY, freeze_garbage, real_time_priority
from cosim.base.system.pulse import FINISHED, RUNNING, Pulse, Who
from cosim.base.system.supervised import Supervised
from cosim.realtime.messages import Ending
from cosim.realtime.signals import pending

STALL_SECONDS = 0.010
"""Beats that stand still for so long belong to a dead loop."""
POLL_SECONDS = 0.001
EASY_POLL_SECONDS = 0.02
"""Without devices nobody is in danger: then it is only the loop's end that is waited for."""
OWN_GAP_SECONDS = 0.004
"""A look that comes this much after the last one says nothing of the loop: this process itself did
not run."""
ENDING_SECONDS = 5.0
"""How long a loop may take to end after it was asked to, or has said so."""
COMMAND_STOPPED_SECONDS = 2.0
"""A command that does not go on for so long because it is stopped: nobody records or watches."""
COMMAND_SLOW_SECONDS = 60.0
"""One that is not stopped may wait for its disk for so long; rows are lost then, and counted."""
BROKEN = 70
"""Exit status of a loop that ended in an exception nobody turned into a sentence."""


def supervise(
    devices: Sequence[tuple[int, Supervised]],
    loop: Callable[[], int],
    pulse: Pulse,
    *,
    command: int | None = None,
    stall: float = STALL_SECONDS,
    real_time: bool = True,
) -> Ending:
    """Run ``loop`` in a child process on the devices that are open here; returns once all is zero.

    ``loop`` returns its exit status. ``devices`` come with their numbers in ``pulse``. ``command``
    is the read end of a pipe that the command alone holds open. The devices are released before
    this returns.
    """
    pulse.supervised_here()
    process = os.fork()
    if process == 0:
        _run_loop(loop, pulse)
    pulse.who, pulse.loop_id = Who.SUPERVISOR, process
    if real_time and devices:
        freeze_garbage()
        real_time_priority(SUPERVISOR_PRIORITY)
    watch = _Watch(process, pulse, command, stall if devices else None)
    killed = watch.to_the_end()
    begun = time.monotonic()
    torn = pulse.torn()
    for number, device in devices:
        device.zero_after_death(torn=torn is not None and torn[0] == number)
    seconds = time.monotonic() - begun
    for _, device in devices:
        device.release()
    status, reason = _ended(watch.reap())
    if killed is not None:
        reason = f"{killed}; it was killed"
    return Ending(status=status, reason=reason, seconds=seconds, killed=killed is not None)


def _run_loop(loop: Callable[[], int], pulse: Pulse) -> None:
    """The child: never returns, and runs none of its parent's exit handlers."""
    status = BROKEN
    pulse.who = Who.LOOP
    try:
        os.setsid()
        status = loop()
    except BaseException as error:
        os.write(2, f"the control loop failed: {type(error).__name__}: {error}\n".encode())
    finally:
        pulse.state(FINISHED)
        os._exit(status)


class _Watch:
    """Waits for the loop's end, or brings it about.

    Without ``stall`` the loop may stand still. Whatever happens to the command, or comes as a
    signal, asks the loop to end.
    """

    def __init__(
        self, process: int, pulse: Pulse, command: int | None, stall: float | None
    ) -> None:
        self._process, self._pulse, self._stall = process, pulse, stall
        self._poll = select.poll()
        if command is not None:
            self._poll.register(command, select.POLLIN)
        self._command = os.getppid()
        self._command_beats: int = 0
        self._heard: int = 0
        self._command_since = self._since = 0.0
        self._ending: float | None = None
        self._wait_status: int | None = None

    def to_the_end(self) -> str | None:
        """Returns once the loop writes no more; why it was killed here, if it was."""
        pulse, last = self._pulse, time.monotonic()
        self._heard, self._since, self._command_since = pulse.counter, last, last
        while True:
            pulse.beat()
            now = time.monotonic()
            if now - last > OWN_GAP_SECONDS:
                self._since += now - last
                self._command_since += now - last
            last = now
            if not pulse.stop_asked and self._is_time_to_end(now):
                pulse.ask_to_stop()
            if self._is_over():
                return None
            reason = self._reason_to_kill(now)
            if reason:
                self._kill()
                return reason
            time.sleep(EASY_POLL_SECONDS if self._stall is None else POLL_SECONDS)

    def reap(self) -> int:
        """The loop's wait status, once the system has freed all that it had."""
        if self._wait_status is None:
            _, self._wait_status = os.waitpid(self._process, 0)
        return self._wait_status

    def _is_over(self) -> bool:
        """Whether the loop writes no more."""
        if self._wait_status is None:
            found, wait_status = os.waitpid(self._process, os.WNOHANG)
            self._wait_status = wait_status if found else None
        return self._wait_status is not None or is_dying(self._process)

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process, signal.SIGKILL)
        while not self._is_over():
            time.sleep(POLL_SECONDS)

    def _is_time_to_end(self, now: float) -> bool:
        """Whether a signal has come here, or the command is gone or stopped."""
        beats = self._pulse.beats(Who.COMMAND)
        if beats != self._command_beats:
            self._command_beats, self._command_since = beats, now
        still = now - self._command_since if beats > 0 else 0.0
        gone = still > COMMAND_SLOW_SECONDS or (
            still > COMMAND_STOPPED_SECONDS and _is_stopped(self._command)
        )
        return pending() or gone or bool(self._poll.poll(0)) or is_dying(self._command)

    def _reason_to_kill(self, now: float) -> str | None:
        pulse, state = self._pulse, self._pulse.loop_state
        if state == FINISHED or pulse.stop_asked:
            self._ending = self._ending or now
            if now - self._ending > ENDING_SECONDS:
                return "the control loop did not end"
        if state != RUNNING or pulse.counter != self._heard:
            self._heard, self._since = pulse.counter, now
        elif self._stall is not None and now - self._since > self._stall:
            return f"the control loop stood still for {self._stall * 1e3:.0f} ms"
        return None


def _is_stopped(process: int) -> bool:
    """Whether a process is stopped rather than waiting for something (proc(5)).

    Where the system does not say, it is.
    """
    try:
        text = Path(f"/proc/{process}/stat").read_text("ascii", errors="replace")
    except OSError:
        return True
    return text.rpartition(")")[2].split()[0] in {"T", "t"}


def _ended(wait_status: int) -> tuple[int, str]:
    status = os.waitstatus_to_exitcode(wait_status)
    if status < 0:
        return status, f"the control loop was killed by {signal.Signals(-status).name}"
    return status, "" if status == 0 else f"the control loop ended with status {status}"
