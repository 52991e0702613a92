"""A start that only shows whether there would be one, in a process of its own.

An FMU is a stranger's native code: it may hang, or take its process down with it. A check must
survive that and name the component.
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import time
from contextlib import suppress
from typing import Any, cast

from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.system.manner import manner
from cosim.master.run.execution.life_cycle import ALL_TOGETHER
from cosim.master.run.simulation import Simulation

START_SECONDS = 20.0
"""Time for all components together."""


def try_to_start(simulation: Simulation, seconds: float = START_SECONDS) -> None:
    """Start every component as a run would, up to the first tick, and throw it away.

    Devices are not opened. Where the system cannot fork, it happens in this process.

    Raises:
        InputError: a component refuses what it was given, hangs or crashes.
        RunError: it failed for another reason.
    """
    if not hasattr(os, "fork"):
        with simulation:
            simulation.rehearse(lambda _component, _what: None)
        return
    simulation.whereabouts.is_watched = True  # by this process
    said, tell = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(said)
        _rehearse(simulation, tell)
    os.close(tell)
    try:
        _conclude(simulation, *_hear(said, child, seconds), seconds)
    finally:
        os.close(said)


def _rehearse(simulation: Simulation, tell: int) -> None:
    """The child's whole life; never returns."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it and ends this
    try:
        _send(tell, None)
        with simulation:
            simulation.rehearse(lambda component, what: _send(tell, (component, what)))
        _send(tell, RunError(simulation.closing_error) if simulation.closing_error else "started")
    except InputError as error:
        _send(tell, error)
    except CohapticError as error:
        _send(tell, RunError(str(error)))
    except BaseException as error:
        _send(tell, RunError(f"starting failed: {type(error).__name__}: {error}"))
    finally:
        os._exit(0)


def _hear(said: int, child: int, seconds: float) -> tuple[list[Any], int | None]:
    """What the child said, and how it ended; ``None`` where it had to be ended."""
    end = time.monotonic() + seconds
    data = b""
    status: int | None = None
    try:
        while (left := end - time.monotonic()) > 0:
            ready, _, _ = select.select([said], [], [], left)
            part = os.read(said, 65536) if ready else b""
            if ready and not part:
                status = os.waitpid(child, 0)[1]
                break
            data += part
    finally:
        if status is None:
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    return _messages(data), status


def _conclude(
    simulation: Simulation, messages: list[Any], status: int | None, seconds: float
) -> None:
    last = messages[-1] if messages else None
    if isinstance(last, InputError | RunError):
        raise last
    if last == "started" and status is not None:
        return
    component, what = cast("tuple[str, str]", last) if last is not None else ALL_TOGETHER
    named, doing = simulation.whereabouts.sentence(simulation.scenario)
    if named:  # a call of its own is going on, or was
        component, what = named, doing
    place = simulation.scenario.locate(
        ("components",) if component == ALL_TOGETHER[0] else ("components", component)
    )
    if status is None:
        raise InputError(f"{component} hangs {what}: not over after {seconds:g} s", place)
    raise InputError(f"{component} {manner(os.waitstatus_to_exitcode(status))} {what}", place)


def _send(tell: int, message: Any) -> None:
    data = pickle.dumps(message)
    frame = len(data).to_bytes(8, "little") + data
    with suppress(BrokenPipeError):
        while frame:
            frame = frame[os.write(tell, frame) :]


def _messages(data: bytes) -> list[Any]:
    found: list[Any] = []
    while len(data) >= 8 and len(data) >= 8 + (size := int.from_bytes(data[:8], "little")):
        found.append(pickle.loads(data[8 : 8 + size]))
        data = data[8 + size :]
    return found
