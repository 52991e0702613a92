"""Whether a process runs no more of its program, though the system has not reaped it yet.

A wait for a process ends when all of its memory is free, 20 to 50 ms after a kill for a loop that
holds 200 MB. It writes nothing from the first moment of its end, though, and that is seen: its
memory is taken from it first, and with that the link to its program.

Source: proc(5), /proc/PID/exe; Linux, kernel/exit.c (do_exit: exit_mm comes after the last return
to the program, before files are closed and the parent is told).
"""

from __future__ import annotations

import sys
from pathlib import Path


def is_dying(process: int) -> bool:
    """Whether it runs no more; ``False`` where the system does not say."""
    if sys.platform != "linux":
        return False
    try:
        Path(f"/proc/{process}/exe").readlink()
    except FileNotFoundError:
        return _has_one_thread(process)
    except OSError:
        return False
    return False


def _has_one_thread(process: int) -> bool:
    """Another thread would go on for a moment; and where nothing is listed, nothing is known."""
    try:
        return len(list(Path(f"/proc/{process}/task").iterdir())) == 1
    except OSError:
        return False
