"""Independent motors in a process of their own, for as long as a test needs a real port."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace


@contextmanager
def motors(board: str) -> Iterator[SimpleNamespace]:
    """Their ``port``; nothing there can prove to be an emulator."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.support.hil.motors", board],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        yield SimpleNamespace(port=process.stdout.readline().strip())
    finally:
        assert process.stdin is not None
        process.stdin.close()
        process.stdout.close()
        process.wait(10)
