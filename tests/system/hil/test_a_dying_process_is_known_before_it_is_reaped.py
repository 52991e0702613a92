"""Who is killed runs no more long before the system has freed it; that is seen, and nothing else.

A supervisor that waited for the end of a killed loop zeroed the motors 20 to 50 ms later.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from cosim.base.system.dying import is_dying

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="other systems do not say")
HELD = 64 << 20
"""Bytes that a child has of its own, which take the system a while to free."""


@contextmanager
def child() -> Iterator[int]:
    process = os.fork()
    if process == 0:
        held = bytearray(os.urandom(4096)) * (HELD // 4096)
        while held:
            time.sleep(60)
    try:
        yield process
    finally:
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)


def test_one_that_lives_or_stands_still_is_not():
    assert not is_dying(os.getpid())
    with child() as process:
        assert not is_dying(process)
        os.kill(process, signal.SIGSTOP)
        assert os.waitpid(process, os.WUNTRACED)[0] == process
        assert not is_dying(process), "it may go on, and write"


def test_one_that_was_killed_is_though_nobody_has_reaped_it():
    with child() as process:
        os.kill(process, signal.SIGKILL)
        end = time.monotonic() + 10.0
        while not is_dying(process):
            assert time.monotonic() < end
            time.sleep(0.0005)
        os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)
        assert is_dying(process), "and it stays so until then"


def test_of_one_that_was_reaped_or_never_was_nothing_is_known():
    with child() as process:
        pass
    assert not is_dying(process)
    assert not is_dying(2**22 + 1), "no number of a process"
