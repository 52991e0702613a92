"""The line that a paced run shows on a terminal, read from its ring in another process."""

from __future__ import annotations

import shutil
import time
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from cosim.cli.support.shown import shown

if TYPE_CHECKING:
    from cosim.realtime.live import Feed
    from cosim.realtime.watcher import Watcher

SHOW_SECONDS = 0.1


class Console:
    """Rewrites one line on stderr some ten times a second, from the process that records."""

    def __init__(self) -> None:
        self._watcher: Watcher | None = None
        self._shown = 0.0

    def __call__(self, feed: Feed) -> None:
        """Show how things stand, where it is time to."""
        now = time.monotonic()
        if now - self._shown < SHOW_SECONDS or not feed.published:
            return
        self._shown = now
        if self._watcher is None:
            from cosim.realtime.watcher import Watcher

            self._watcher = Watcher(feed.path)
        status = self._watcher.status()
        if status is not None:
            width = shutil.get_terminal_size().columns - 1
            shown.show(f"\r{status.line()[:width]:{width}}")

    def end(self) -> None:
        """The run is over: what comes next begins on a line of its own."""
        shown.finish()
        if self._watcher is not None:
            click.echo("", err=True)


@contextmanager
def ended(console: Console | None) -> Generator[None]:
    """A run with a console line, or without one."""
    try:
        yield None
    finally:
        if console is not None:
            console.end()
        else:
            shown.finish()
