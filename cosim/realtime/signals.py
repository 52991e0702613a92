"""Signals of a paced run: every one that would end or stop a process means "zero, confirm, end".

They are blocked before the first fork. The supervisor leaves them so and asks what is pending; the
loop and the command turn them into a flag. So none of the three dies or stops of one, and none
interrupts a zeroing. KILL and STOP cannot be had: against them the others watch.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from types import FrameType

_NAMES = (
    *("SIGINT", "SIGQUIT", "SIGTERM", "SIGHUP"),
    *("SIGTSTP", "SIGTTIN", "SIGTTOU"),
    *("SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF"),
    *("SIGIO", "SIGPWR", "SIGSTKFLT", "SIGXCPU", "SIGXFSZ"),
)
ENDING = frozenset(number for name in _NAMES if (number := getattr(signal, name, None)) is not None)
"""Those whose default is to end or to stop a process, but for those of a broken program."""


class Ear:
    """Whether a signal to end has come; :meth:`listen` once a process is ready for it."""

    def __init__(self, ask_to_end: Callable[[], None]) -> None:
        self._ask_to_end = ask_to_end
        self.heard: signal.Signals | None = None
        """The first that came."""

    def note(self, number: int, _frame: FrameType | None) -> None:
        """Take a signal."""
        if self.heard is None:
            self.heard = signal.Signals(number)
            self._ask_to_end()

    def listen(self) -> None:
        """From now on signals set the flag, those that came while they were blocked, too."""
        for number in ENDING:
            signal.signal(number, self.note)
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)


def pending() -> bool:
    """Whether a signal to end waits at a process that keeps them blocked."""
    return not ENDING.isdisjoint(signal.sigpending())


@contextmanager
def blocked() -> Generator[None]:
    """Nothing of ``ENDING`` is delivered inside; children inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def heard_by(ear: Ear) -> Generator[int]:
    """The command's signals go to ``ear`` inside, and wake whoever waits on the descriptor.

    Begins with signals blocked, so that nothing can come between a fork and this; those that came
    meanwhile are heard. Afterwards everything is as it was.
    """
    read, write = os.pipe()
    os.set_blocking(read, False)
    os.set_blocking(write, False)
    before = {number: signal.getsignal(number) for number in (*ENDING, signal.SIGPIPE)}
    wake = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    try:
        ear.listen()
        yield read
    finally:
        signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        while pending():
            with suppress(ValueError):
                ear.note(signal.sigwait(ENDING), None)
        signal.set_wakeup_fd(wake)
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        os.close(read)
        os.close(write)
