"""The process that outlives the control loop: it opened the ports, and it zeroes what is left.

It forks the loop, which inherits the open descriptors; it watches the loop's counter; and when the
loop is gone, stands still or stops answering, it kills and reaps it, completes or drains the frame
that was under way, and sends zero until an answer confirms it. Linux and macOS.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from cosim.base.pulse import FINISHED, RUNNING, Pulse
from hil.device.contract import CUT_POWER
from hil.device.device import Device
from hil.realtime.system import SUPERVISOR_PRIORITY, freeze_garbage, real_time_priority

STALL_SECONDS = 0.010
"""A counter that stands still for so long belongs to a dead loop."""
POLL_SECONDS = 0.001
EASY_POLL_SECONDS = 0.02
"""Without devices nobody is in danger: then it is only the loop's end that is waited for."""
ENDING_SECONDS = 5.0
"""How long a loop may take to end after it has said so (it has zeroed its devices first)."""
BROKEN = 70
"""Exit status of a loop that ended in an exception nobody turned into a sentence."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a supervised loop ended."""

    status: int
    """The loop's exit status; minus the signal's number where a signal killed it."""
    reason: str
    """Empty for a loop that ended by itself with status 0."""
    zeroed: tuple[bool, ...]
    """Per device: whether a zero was confirmed after the loop's end."""
    seconds: float
    """From noticing the end to the last confirmation (s)."""

    def sentences(self, devices: Sequence[Device]) -> list[str]:
        """What a person has to know."""
        said = [self.reason] if self.reason else []
        for device, zeroed in zip(devices, self.zeroed, strict=True):
            if not zeroed and not device.in_process:
                if device.watchdog.verified:
                    said.append(f"{device.name} does not answer; its own watchdog drops the torque")
                else:
                    said.append(f"{device.name}: output unknown, {CUT_POWER}")
        return said


def supervise(
    devices: Sequence[Device],
    loop: Callable[[], int],
    pulse: Pulse,
    *,
    stall: float = STALL_SECONDS,
    real_time: bool = True,
) -> Ending:
    """Run ``loop`` in a child process on the devices that are open here; returns once all is zero.

    ``loop`` returns its exit status. The devices are released before this returns.
    """
    owner = os.getppid()
    process = os.fork()
    if process == 0:
        _run_loop(loop, pulse)
    if real_time and devices:
        freeze_garbage()
        real_time_priority(SUPERVISOR_PRIORITY)
    with _passing_on_signals(process):
        status, reason = _watch(process, pulse, stall if devices else None, owner)
    begun = time.monotonic()
    torn = pulse.torn()
    zeroed = tuple(
        device.zero_after_death(torn=torn is not None and torn[0] == number)
        for number, device in enumerate(devices)
    )
    seconds = time.monotonic() - begun
    for device in devices:
        device.release()
    return Ending(status=status, reason=reason, zeroed=zeroed, seconds=seconds)


def _run_loop(loop: Callable[[], int], pulse: Pulse) -> None:
    """The child: never returns, and runs none of its parent's exit handlers."""
    status = BROKEN
    try:
        status = loop()
    except BaseException as error:
        os.write(2, f"the control loop failed: {type(error).__name__}: {error}\n".encode())
    finally:
        pulse.state(FINISHED)
        os._exit(status)


def _watch(process: int, pulse: Pulse, stall: float | None, owner: int) -> tuple[int, str]:
    """Wait for the loop's end, or bring it about: (status, what happened).

    Without ``stall`` the loop may stand still. Where the process that began the run (``owner``)
    dies, nobody records or watches any more: the loop is asked to end.
    """
    last, since = pulse.counter, time.monotonic()
    finished: float | None = None
    orphan = False
    while True:
        if not orphan and os.getppid() != owner:
            orphan = True
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGTERM)
        found, wait_status = os.waitpid(process, os.WNOHANG)
        if found:
            return _ended(wait_status)
        now = time.monotonic()
        if pulse.loop_state == RUNNING:
            if pulse.counter != last:
                last, since = pulse.counter, now
            elif stall is not None and now - since > stall:
                return _kill(process, f"the control loop stood still for {stall * 1e3:.0f} ms")
        elif pulse.loop_state == FINISHED:
            finished = finished or now
            if now - finished > ENDING_SECONDS:
                return _kill(process, "the control loop did not end")
        else:
            since = now
        time.sleep(EASY_POLL_SECONDS if stall is None else POLL_SECONDS)


def _kill(process: int, reason: str) -> tuple[int, str]:
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, signal.SIGKILL)
    _, wait_status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(wait_status), f"{reason}; it was killed"


def _ended(wait_status: int) -> tuple[int, str]:
    status = os.waitstatus_to_exitcode(wait_status)
    if status < 0:
        return status, f"the control loop was killed by {signal.Signals(-status).name}"
    return status, "" if status == 0 else f"the control loop ended with status {status}"


@contextlib.contextmanager
def _passing_on_signals(process: int) -> Any:
    """A signal to stop goes to the loop, which zeroes at its next tick; it never ends us first."""

    def pass_on(number: int, _: object) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, number)

    before = {number: signal.signal(number, pass_on) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
