"""What belongs to the process and an FMU may change: put back after it was called.

Handlers of faults (SIGSEGV and the like) are left to whoever set them: a runtime that an FMU brings
along, such as a virtual machine, may live on them. How the processor computes is put back by the
kernel after each call (``kernel/sources/process.c``), and here for the calls outside of it.
"""

from __future__ import annotations

import ctypes
import locale
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from cosim.master.kernel.native import library

_OURS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGCHLD", "SIGPIPE")
"""What ends a run, and what its processes hear of each other."""
_ACTION_BYTES = 512
"""More than ``struct sigaction`` has anywhere."""
_MEANT = (slice(0, 16), slice(136, 140))
"""Of ``struct sigaction`` of Linux: the handler with the signals that it blocks, and the flags. The
C library leaves what it likes in the rest. On macOS the first is all of it."""


class Surroundings:
    """Those of this process as they are now; ``put_back`` makes them so again."""

    def __init__(self) -> None:
        self._folder = _folder()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._mode = library().kernel_float_mode()
        numbers = [getattr(signal, name) for name in _OURS if hasattr(signal, name)]
        self._actions = {number: _action(number) for number in numbers}
        self._blocked = _blocked()

    def put_back(self) -> list[str]:
        """What had been changed since, in words."""
        changed: list[str] = []
        if self._folder and _folder() != self._folder:
            changed.append("the working directory")
            with suppress(OSError):
                os.chdir(self._folder)
        if locale.setlocale(locale.LC_ALL) != self._locale:
            changed.append("the locale")
            locale.setlocale(locale.LC_ALL, self._locale)
        if library().kernel_restore_float_mode(self._mode):
            changed.append("the floating point mode")
        for number, action in self._actions.items():
            now = _action(number)
            if any(now[part] != action[part] for part in _MEANT):
                changed.append(f"the handler of {signal.Signals(number).name}")
                _set_action(number, action)
        if _blocked() != self._blocked:
            changed.append("which signals are blocked")
            signal.pthread_sigmask(signal.SIG_SETMASK, self._blocked)
        return changed


def _folder() -> str:
    try:
        return os.getcwd()  # noqa: PTH109 - Path.cwd() is slower, and this is asked often
    except OSError:
        return ""


def _blocked() -> set[Any]:
    if sys.platform == "win32":
        return set()
    return set(signal.pthread_sigmask(signal.SIG_BLOCK, ()))


def _sigaction() -> Callable[..., int] | None:
    if sys.platform == "win32":
        return None
    return ctypes.CDLL(None).sigaction


def _action(number: int) -> bytes:
    """The handler with its flags, as the system keeps it."""
    sigaction = _sigaction()
    if sigaction is None:
        return b""
    found = ctypes.create_string_buffer(_ACTION_BYTES)
    sigaction(number, None, found)
    return found.raw


def _set_action(number: int, action: bytes) -> None:
    sigaction = _sigaction()
    if sigaction is not None:
        sigaction(number, ctypes.create_string_buffer(action, _ACTION_BYTES), None)
