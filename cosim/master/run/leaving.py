"""``exit()`` inside of an FMU, in a process that nobody watches: a sentence, and status 1.

The commands run simulations in a child, whose end the parent tells of. Who runs one in a process of
their own would only see that end, with whatever status the FMU chose, 0 included. The C library
offers one thing before it: a list of what is called first (``atexit``).
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from functools import cache

from cosim.master.kernel.native import function_address, library

_SAY = ctypes.CFUNCTYPE(None)


@contextmanager
def told_of(sentence: Callable[[], str]) -> Generator[None]:
    """While this lasts, ``exit()`` writes the sentence to stderr and ends with status 1."""
    is_there = sys.platform != "win32" and _prepared()
    if not is_there:
        yield
        return

    def say() -> None:
        try:
            for stream in (sys.stdout, sys.stderr):
                with suppress(OSError, ValueError, AttributeError):
                    stream.flush()
            os.write(2, f"{sentence()}\n".encode(errors="replace"))
        finally:
            os._exit(1)

    called = _SAY(say)
    before = library().kernel_on_leaving(function_address(called))
    try:
        yield
    finally:
        library().kernel_on_leaving(before)


@cache
def _prepared() -> bool:
    """Have the kernel called at the process's end; whether that can be."""
    register = getattr(ctypes.CDLL(None), "__cxa_atexit", None)
    if register is None:
        return False
    # A fork's Python is gone when it ends in the ordinary way.
    os.register_at_fork(after_in_child=lambda: library().kernel_on_leaving(None))
    address = function_address(library().kernel_leaving)
    register.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
    return register(address, None, None) == 0
