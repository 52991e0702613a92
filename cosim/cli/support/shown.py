"""Standard error of a run that nothing may hold up: a frozen terminal (Ctrl-S) holds nobody.

What is said waits until it fits; a status line that does not fit now is left out.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys

import click

_PIPE_FITS = 4096
"""A pipe that says it takes something takes so many bytes without waiting (PIPE_BUF, pipe(7))."""


class Shown:
    """Writes to standard error without ever waiting; :meth:`finish` alone waits."""

    def __init__(self) -> None:
        self._waiting = b""
        self._own: int | None = None
        """The terminal opened once more: not waiting is then nobody else's business."""
        self._is_open = False

    def say(self, sentence: str) -> None:
        """Show a sentence, now or as soon as it fits."""
        descriptor = self._descriptor()
        if descriptor is None:
            click.echo(sentence, err=True)
            return
        self._waiting += f"{sentence}\n".encode(errors="replace")
        self._flush(descriptor)

    def show(self, text: str) -> None:
        """Show a text that is worth nothing later."""
        descriptor = self._descriptor()
        if descriptor is None:
            click.echo(text, err=True, nl=False)
            return
        self._flush(descriptor)
        if not self._waiting:
            self._waiting = text.encode(errors="replace")
            if not self._flush(descriptor):
                self._waiting = b""

    def finish(self) -> None:
        """Show what is left, however long that takes."""
        rest, self._waiting = self._waiting, b""
        if rest:
            click.echo(rest.decode(errors="replace"), err=True, nl=False)
        if self._own is not None:
            os.close(self._own)
            self._own, self._is_open = None, False

    def _descriptor(self) -> int | None:
        """Where to write; ``None`` where standard error is none of the system's."""
        try:
            descriptor = sys.stderr.fileno()
            sys.stderr.flush()
        except (OSError, ValueError, AttributeError):
            return None
        if not self._is_open:
            self._is_open = True
            with contextlib.suppress(OSError):
                flags = os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK
                self._own = os.open(os.ttyname(descriptor), flags)
        return descriptor if self._own is None else self._own

    def _flush(self, descriptor: int) -> bool:
        """Whether anything was taken of what waits."""
        before = len(self._waiting)
        with contextlib.suppress(OSError):
            while self._waiting and _takes(descriptor):
                self._waiting = self._waiting[os.write(descriptor, self._waiting[:_PIPE_FITS]) :]
        return len(self._waiting) < before


def _takes(descriptor: int) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    return any(events & select.POLLOUT for _, events in poll.poll(0))


shown = Shown()
"""Of this process: what is said first is shown first."""
