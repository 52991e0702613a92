"""A command as a person at a terminal sees it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import struct
import subprocess
import termios
from pathlib import Path

from tests.support.command import COHAPTIC


def at_a_terminal(columns: int, arguments: list[str], folder: Path) -> str:
    """What is shown on a terminal of so many columns; what goes beside it is left out."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 60, columns, 0, 0))
    process = subprocess.Popen(
        [*COHAPTIC, *arguments],
        cwd=folder,
        stdin=theirs,
        stdout=theirs,
        stderr=subprocess.DEVNULL,
        env={key: value for key, value in os.environ.items() if key not in {"COLUMNS", "LINES"}},
    )
    os.close(theirs)
    shown = b""
    with contextlib.suppress(OSError):  # the terminal's other end is closed
        while piece := os.read(ours, 4096):
            shown += piece
    os.close(ours)
    assert process.wait(60) in {0, 1}
    return shown.decode()
