"""How a process has ended, in words."""

from __future__ import annotations

import signal


def manner(status: int) -> str:
    """What to say of a process that had no reason to end: ``status`` is negative after a signal."""
    if status < 0:
        said = (signal.strsignal(-status) or "").lower()
        try:
            name = signal.Signals(-status).name
        except ValueError:  # one of real time, or of another system
            name = f"signal {-status}"
        return f"crashed ({name}: {said})"
    return f"ended the process (exit status {status})"
