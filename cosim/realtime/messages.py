"""What supervisor and loop tell the command over a pipe, and how a message is cut out of it."""

from __future__ import annotations

import contextlib
import os
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.system.grants import Grant
from cosim.master.run.outcome import Outcome
from cosim.realtime.shared.text_ring import Change


@dataclass(frozen=True, slots=True)
class Begun:
    """The first tick is about to run."""


@dataclass(slots=True)
class LoopReport:
    """What the loop's process says before it ends."""

    outcome: Outcome | None = None
    error: InputError | RunError | None = None
    """What ended it; what the user wrote is told with its places."""
    left: str | None = None
    """What a Python component gave to ``sys.exit``, where one did."""
    deadlines: dict[str, Any] = field(default_factory=dict[str, Any])
    grants: list[Grant] = field(default_factory=list[Grant])
    slow: list[str] = field(default_factory=list[str])
    """What has to be said of boards that took no command at many ticks."""
    latency: dict[str, int] = field(default_factory=dict[str, int])
    """By device: ticks that its measurements are older than the FMU's."""
    facts: Mapping[str, Any] | None = None
    texts: list[Change] = field(default_factory=list[Change])
    """The last changes of texts for which there was no room in their ring."""


def as_told(error: CohapticError) -> InputError | RunError:
    """An error as it passes between processes: any but the user's own as its sentence."""
    if isinstance(error, InputError):
        return error
    return InputError(str(error)) if error.exit_status == 2 else RunError(str(error))


@dataclass(frozen=True, slots=True)
class Over:
    """All components are closed as well: the loop's process now ends by itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a supervised loop ended."""

    status: int
    """The loop's exit status; minus the signal's number where a signal killed it."""
    reason: str
    """Empty for a loop that ended by itself with status 0."""
    killed: bool = False
    """Whether the supervisor killed it."""
    seconds: float
    """From noticing the end to the last confirmation (s)."""


Message = Begun | LoopReport | Over | Ending | Grant


def say(pipe: int, message: Message) -> None:
    """Send a message; a command that is gone hears nothing."""
    data = pickle.dumps(message)
    frame = len(data).to_bytes(8, "little") + data
    with contextlib.suppress(BrokenPipeError):
        while frame:
            frame = frame[os.write(pipe, frame) :]


def split(data: bytes) -> tuple[list[Message], bytes]:
    """Whole messages, and the bytes that are left."""
    found: list[Message] = []
    while len(data) >= 8 and len(data) >= 8 + (size := int.from_bytes(data[:8], "little")):
        found.append(pickle.loads(data[8 : 8 + size]))
        data = data[8 + size :]
    return found, data
