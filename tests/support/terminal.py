"""A command as a person at a terminal sees it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import struct
import subprocess
import termios
import time
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


class Terminal:
    """A person at a terminal: reads what is asked and types."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.ours, theirs = pty.openpty()
        command = [*COHAPTIC, *arguments]
        self.process = subprocess.Popen(
            command, cwd=folder, stdin=theirs, stdout=theirs, stderr=theirs
        )
        os.close(theirs)
        self.said = ""

    def listen_for(self, text: str) -> None:
        """Until it was said, and not what was said before."""
        end = time.monotonic() + 60
        while text not in self.said:
            assert time.monotonic() < end, self.said
            if select.select([self.ours], [], [], 0.1)[0]:
                self.said += os.read(self.ours, 4096).decode(errors="replace")
        self.said = self.said.partition(text)[2]

    def type(self, text: str) -> None:
        """After the flush of what was typed ahead."""
        time.sleep(0.05)
        os.write(self.ours, text.encode())

    def kill(self) -> None:
        """With SIGKILL."""
        self.process.kill()
        self.process.wait()
