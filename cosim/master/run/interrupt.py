"""Ctrl-C as a wish that the loop grants between two chunks, so that nothing is left half done."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass(slots=True)
class Wish:
    """Whether somebody has asked for the end."""

    is_made: bool = False


@contextmanager
def wish_to_stop(heard: Callable[[], None] = lambda: None) -> Generator[Wish]:
    """Turn the first Ctrl-C into a wish; a second one raises ``KeyboardInterrupt`` at once.

    ``heard`` is told of each.

    Outside of the main thread, where Python hears no signals, the wish is never made.
    """
    wish = Wish()
    if threading.current_thread() is not threading.main_thread():
        yield wish
        return

    def hear(_number: int, _frame: FrameType | None) -> None:
        heard()
        if wish.is_made:
            raise KeyboardInterrupt
        wish.is_made = True

    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:
        yield wish  # somebody else has taken the signal over
        return
    signal.signal(signal.SIGINT, hear)
    try:
        yield wish
    finally:
        signal.signal(signal.SIGINT, before)
