"""Only what a command prints goes to stdout; what native code prints goes to stderr.

An FMU may print whatever it likes, at any time up to the end of the process, and the C library
writes a printed line long after it was printed. So the descriptor itself is handed over for good.
"""

from __future__ import annotations

import os
import sys


def reserve_stdout() -> None:
    """Let file descriptor 1 lead to stderr, and ``sys.stdout`` to where descriptor 1 led before."""
    try:
        if sys.stdout.fileno() != 1:
            return
        sys.stdout.flush()
        own = os.dup(1)
        try:
            os.dup2(2, 1)
        except OSError:  # there is no stderr: then it is lost
            with open(os.devnull, "wb") as nowhere:  # noqa: PTH123 - a device, not a path
                os.dup2(nowhere.fileno(), 1)
    except (OSError, ValueError, AttributeError):  # no stdout at all
        return
    before = sys.stdout
    sys.stdout = os.fdopen(
        own,
        "w",
        encoding=before.encoding,
        errors=before.errors,
        buffering=1 if os.isatty(own) else -1,
        closefd=False,
    )
