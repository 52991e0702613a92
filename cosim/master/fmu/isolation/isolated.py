"""An FMU whose library lives in a process of its own; a ``Binding`` as the others.

The kernel calls over shared memory (``cosim/master/kernel/sources/isolation.c``), Python over a
socket. The process is a fresh one, not a fork: it must not begin with the libraries that this one
has loaded.
"""

from __future__ import annotations

import ctypes
import json
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cosim.base.component import VariableType
from cosim.base.errors import InputError, RunError
from cosim.base.system.manner import manner
from cosim.base.system.room import nameless_shared_file
from cosim.master.fmu.binding import EVENT_FUNCTIONS, OK, InstanceWanted
from cosim.master.fmu.isolation.exchange import Exchange, Room, receive, send
from cosim.master.fmu.log import Log
from cosim.master.kernel.codes import FMI2_TYPE_CODES, TYPE_CODES
from cosim.master.kernel.native import library

GONE = 100
"""The kernel's status for a call whose process has ended (``isolation.h``)."""
LOOKS = 2000
"""Looks at the shared memory before a side sleeps: some 20 µs, longer than a small FMU's step."""
_ENDING_SECONDS = 5.0
_BEGIN = (
    "import sys, json; settings = json.loads(sys.argv[1]); sys.path[:] = settings['path']; "
    "from cosim.master.fmu.isolation.worker import work; work(settings)"
)


class ProcessEnded(RunError):
    """The process of an isolated FMU ended in a call; ``manner`` says how."""

    def __init__(self, manner: str, call: str) -> None:
        super().__init__(f"its process {manner} in {call}")
        self.manner = manner


class Isolated:
    """One instance in a process that it has for itself.

    ``calling`` is told of the function in which the process ended.
    """

    def __init__(
        self, path: Path, version: int, room: Room, calling: Callable[[str], None]
    ) -> None:
        if sys.platform == "win32":
            raise InputError("isolate: process needs Linux or macOS")
        self.handle = 0
        self._version, self._calling = version, calling
        with ExitStack() as ours, ExitStack() as theirs:
            what = "the memory that an isolated FMU shares with its process"
            file = ours.enter_context(nameless_shared_file(room.size, what))
            ear, their_mouth = os.pipe()
            their_ear, mouth = os.pipe()
            for end, stack in (
                (ear, ours),
                (mouth, ours),
                (their_ear, theirs),
                (their_mouth, theirs),
            ):
                stack.callback(os.close, end)
            self._talk, their_talk = socket.socketpair()
            ours.callback(self._talk.close)
            theirs.callback(their_talk.close)
            self._exchange = Exchange(file.fileno(), room, ear, mouth, LOOKS)
            files = (file.fileno(), their_ear, their_mouth, their_talk.fileno())
            settings = {
                "path": sys.path,
                "files": files,
                "room": (room.references, room.values),
                "looks": LOOKS,
                "version": version,
                "library": str(path),
            }
            self._process = subprocess.Popen(
                [sys.executable, "-c", _BEGIN, json.dumps(settings)],
                pass_fds=files,
                stdin=subprocess.DEVNULL,
            )
            self._files = ours.pop_all()

    @property
    def log(self) -> Log:
        """What the FMU says; it outlives the process."""
        return self._exchange.log

    @property
    def is_gone(self) -> bool:
        """Whether the process was found to have ended."""
        return bool(self._exchange.side.is_gone)

    def manner(self) -> str:
        """How the process ended, which it has."""
        try:
            return manner(self._process.wait(_ENDING_SECONDS))
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return "closed its end of the exchange"

    def end(self) -> None:
        """Let the process end, after which nothing can be called."""
        self.handle = 0
        self._exchange.side.is_gone = 1
        self._files.close()
        try:
            self._process.wait(_ENDING_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def load(self) -> None:
        """Load the library there.

        Raises:
            InputError: it cannot be loaded, or lacks a function.
        """
        self._ask("load")

    def instantiate(self, wanted: InstanceWanted) -> bool:
        """Make the instance; whether the FMU did."""
        made = bool(self._ask("instantiate", wanted))
        self.handle = ctypes.addressof(self._exchange.side) if made else 0
        return made

    def choose_log_categories(self, categories: Sequence[str]) -> int:
        """Log these categories and no others."""
        return self._ask("choose_log_categories", categories)

    def set_values(self, kind: VariableType, reference: int, values: Sequence[Any]) -> int:
        """Set a variable's elements.

        Raises:
            ValueError: a value does not fit the type.
        """
        return self._ask("set_values", kind, reference, values)

    def set_texts(
        self, kind: VariableType, references: Sequence[int], contents: Sequence[bytes]
    ) -> int:
        """Set all elements of variables whose type is a text's; a message of its own."""
        return self._ask("set_texts", kind, references, contents)

    def get_texts(
        self, kind: VariableType, references: Sequence[int], count: int
    ) -> tuple[int, list[bytes | None]]:
        """The status, and the elements of variables whose type is a text's; a message of its own.

        Raises:
            ValueError: one is longer than what is carried.
        """
        return self._ask("get_texts", kind, references, count)

    def enter_configuration(self) -> int:
        """Enter configuration mode."""
        return self._ask("enter_configuration")

    def exit_configuration(self) -> int:
        """Leave configuration mode."""
        return self._ask("exit_configuration")

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """Say when the run begins and ends (s), where that has a call of its own."""
        return self._ask("set_up_experiment", start_time, stop_time)

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode."""
        return self._ask("enter_initialisation", start_time, stop_time)

    def set_intervals(self, references: Sequence[int], intervals: Sequence[float]) -> int:
        """Say at which intervals (s) clocks will tick that the importer has the choice of."""
        return self._ask("set_intervals", references, intervals)

    def exit_initialisation(self) -> int:
        """Leave initialisation mode."""
        return self._ask("exit_initialisation")

    def save_state(self) -> tuple[int, bytes]:
        """The status, and the whole state as bytes."""
        return self._ask("save_state")

    def load_state(self, content: bytes) -> int:
        """Restore what ``save_state`` returned."""
        return self._ask("load_state", content)

    def look_at_state(self, at: Any) -> int:
        """Have the whole state as bytes; nothing is kept over there."""
        status, at.content = self.save_state()
        return status

    def keep_state(self) -> tuple[int, bytes]:
        """The status, and the state: bytes, which any process can take."""
        return self.save_state()

    def put_state(self, state: bytes) -> int:
        """Go back to a state that was kept."""
        return self.load_state(state)

    def drop_state(self, state: bytes) -> int:
        """Nothing but bytes was kept."""
        return OK

    def missing_state_functions(self) -> list[str]:
        """What the library lacks to save and to load a state."""
        return self._ask("missing_state_functions")

    def asks_to_end(self) -> tuple[int, bool]:
        """The status, and whether a step was discarded because the model has come to its end."""
        return self._ask("asks_to_end")

    def do_step_address(self) -> int:
        """What the kernel calls in place of the step function."""
        return library().kernel_isolated(self._version, -1, 0)

    def accessor_address(self, kind: VariableType, *, is_set: bool) -> int:
        """What the kernel calls in place of a type's set or get function."""
        codes = FMI2_TYPE_CODES if self._version == 2 else TYPE_CODES
        return library().kernel_isolated(self._version, codes[kind], is_set)

    def missing_event_functions(self) -> list[str]:
        """What the library lacks for event mode."""
        return self._ask("missing_event_functions")

    def event_addresses(self) -> list[int]:
        """What the kernel calls in place of the functions of event mode."""
        numbers = range(len(EVENT_FUNCTIONS))
        return [library().kernel_isolated(self._version, -2 - number, 0) for number in numbers]

    def reset(self) -> int | None:
        """Be as after ``instantiate``, or ``None`` where the library has no such function."""
        return self._ask("reset")

    def terminate(self) -> int:
        """End the run."""
        return self._ask("terminate")

    def free(self) -> None:
        """Give the instance back."""
        self._ask("free")
        self.handle = 0

    def _ask(self, method: str, *arguments: Any) -> Any:
        """What the same method of the binding there returns or raises."""
        try:
            is_well, content = self._talk_about((method, arguments))
        except (EOFError, OSError):
            self._exchange.side.is_gone = 1
            call = self._exchange.noted or "the start of its process"
            self._calling(call)
            raise ProcessEnded(self.manner(), call) from None
        if is_well:
            return content
        raise content

    def _talk_about(self, request: Any) -> tuple[bool, Any]:
        if library().kernel_isolated_ask(ctypes.addressof(self._exchange.side)) == GONE:
            raise EOFError
        send(self._talk, request)
        return receive(self._talk)
