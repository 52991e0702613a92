"""What an FMU says through its logger, and what of it belongs into a sentence."""

from __future__ import annotations

import ctypes
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from weakref import finalize

from cosim.master.kernel.native import LogStruct, library

_BYTES = 8192
_LAST_LINES = 3
_SERIOUS = 2
"""The least status (discard) that is a reason."""


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

    def __init__(self) -> None:
        self._text = ctypes.create_string_buffer(_BYTES)
        self._grave = ctypes.create_string_buffer(_BYTES)
        self._struct = LogStruct(
            ctypes.addressof(self._text), ctypes.addressof(self._grave), _BYTES, 0, 0, 0, None
        )
        self._close: Callable[[], object] = lambda: None

    @property
    def address(self) -> int:
        """The environment that the FMU is to hand back."""
        return ctypes.addressof(self._struct)

    def open(self) -> None:
        """Take messages."""
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
        return _reasons(self._struct) or _reasons(library().kernel_log_stray().contents)

    def said(self) -> tuple[Said, ...]:
        """All that was not well among the last that was said, each text once."""
        if not self._struct.grave_used:
            return ()
        return tuple(
            Said(STATUS_NAMES[status] if status < len(STATUS_NAMES) else str(status), text, count)
            for (status, text), count in Counter(_grave(self._struct)).items()
        )


def _reasons(log: LogStruct) -> list[str]:
    grave = _grave(log)
    errors = [text for status, text in grave if status >= _SERIOUS]
    chatter = _lines(log.text, log.used)[-_LAST_LINES:]
    return list(dict.fromkeys(errors or [text for _, text in grave] or chatter))


def _grave(log: LogStruct) -> list[tuple[int, str]]:
    """Status and text; the first may be half a message, without its status."""
    lines = _lines(log.grave, log.grave_used)
    return [(int(line[0]), line[1:].strip()) for line in lines if line[0].isdigit()]


def _lines(text: int, used: int) -> list[str]:
    whole = ctypes.string_at(text, used).decode(errors="replace")
    return [line.strip() for line in whole.split("\n") if line.strip()]
