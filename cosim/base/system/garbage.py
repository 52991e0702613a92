"""Building many objects without the garbage collector looking through all of them again."""

from __future__ import annotations

import gc
from collections.abc import Generator
from contextlib import contextmanager

SELDOM = 50_000
"""Objects more than were freed before the youngest are looked through; Python's own is 700."""


def collect_seldom() -> None:
    """For a process that imports and builds much that stays, and leaves little in circles."""
    gc.set_threshold(SELDOM, *gc.get_threshold()[1:])


@contextmanager
def without_collecting() -> Generator[None]:
    """Put collecting off while something large is built that stays: it would find nothing."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
