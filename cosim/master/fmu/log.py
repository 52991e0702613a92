"""What an FMU says through its logger, and what of it belongs into a sentence."""

from __future__ import annotations

import ctypes
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from weakref import finalize

from cosim.master.kernel.fmu_structures import LogStruct
from cosim.master.kernel.native import library

_BYTES = 8192
_LAST_LINES = 3
_SERIOUS = 2
"""The least status (discard) that is a reason."""


LOG_BYTES = -(-(ctypes.sizeof(LogStruct) + 2 * _BYTES) // 64) * 64
"""What a log takes of memory that is given to it."""
STATUS_NAMES = ("ok", "warning", "discard", "error", "fatal", "pending")


@dataclass(frozen=True, slots=True)
class Said:
    """A message, with the status that it was logged under, and how often it came."""

    status: str
    text: str
    count: int

    def __str__(self) -> str:
        return f"{self.status}: {self.text}" + (f" ({self.count} times)" if self.count > 1 else "")


class Log:
    """One instance's log; the kernel writes it, from whatever thread the FMU calls.

    ``open`` before the FMU knows of it, ``close`` when it is gone.
    """

    def __init__(self, memory: memoryview | None = None) -> None:
        """In ``memory`` where another process writes or reads it, too."""
        size = ctypes.sizeof(LogStruct) + 2 * _BYTES
        room = bytearray(size) if memory is None else memory
        self._struct = LogStruct.from_buffer(room)
        begin = ctypes.sizeof(LogStruct)
        self._text = (ctypes.c_char * _BYTES).from_buffer(room, begin)
        self._grave = (ctypes.c_char * _BYTES).from_buffer(room, begin + _BYTES)
        self._close: Callable[[], object] = lambda: None

    @property
    def address(self) -> int:
        """The environment that the FMU is to hand back."""
        return ctypes.addressof(self._struct)

    def open(self) -> None:
        """Take messages."""
        self._struct.text = ctypes.addressof(self._text)
        self._struct.grave = ctypes.addressof(self._grave)
        self._struct.capacity = _BYTES
        library().kernel_log_open(self.address)
        # A log that nobody has any more must not be written.
        closing = finalize(self, library().kernel_log_close, self.address)
        closing.atexit = False
        self._close = closing

    def forget(self) -> None:
        """Begin anew: what was said belongs to a run that is over."""
        self._struct.used = self._struct.grave_used = self._struct.messages = 0

    def close(self) -> None:
        """Take no more; what was said stays."""
        self._close()

    def reasons(self) -> list[str]:
        """What belongs into a sentence, oldest first, each text once.

        Errors; where there are none, warnings; then the last of the chatter. What came with another
        environment is anybody's and counts where the FMU itself said nothing.
        """
        stray = library().kernel_log_stray().contents
        return _reasons(*self._what_was_said()) or _reasons(
            _lines(stray.text, stray.used), _lines(stray.grave, stray.grave_used)
        )

    def reason(self) -> str:
        """The end of a sentence about the FMU: ``; it said: ...``, or nothing."""
        found = self.reasons()
        return f"; it said: {' / '.join(found)}" if found else ""

    def said(self) -> tuple[Said, ...]:
        """All that was not well among the last that was said, each text once."""
        if not self._struct.grave_used:
            return ()
        return tuple(
            Said(STATUS_NAMES[status] if status < len(STATUS_NAMES) else str(status), text, count)
            for (status, text), count in Counter(_graded(self._what_was_said()[1])).items()
        )

    def _what_was_said(self) -> tuple[list[str], list[str]]:
        """The lines that are well, and those that are not: by addresses of this process."""
        return (
            _lines(ctypes.addressof(self._text), self._struct.used),
            _lines(ctypes.addressof(self._grave), self._struct.grave_used),
        )


def _reasons(chatter: list[str], grave: list[str]) -> list[str]:
    graded = _graded(grave)
    errors = [text for status, text in graded if status >= _SERIOUS]
    texts = [text for _, text in graded]
    return list(dict.fromkeys(errors or texts or chatter[-_LAST_LINES:]))


def _graded(lines: list[str]) -> list[tuple[int, str]]:
    """Status and text; the first may be half a message, without its status."""
    return [(int(line[0]), line[1:].strip()) for line in lines if line[0].isdigit()]


def _lines(text: int, used: int) -> list[str]:
    whole = ctypes.string_at(text, used).decode(errors="replace")
    return [line.strip() for line in whole.split("\n") if line.strip()]
