"""The probe of others counts what others take, and nothing that the test itself has started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.support.machine import timed
from tests.support.others import OthersProbe, of_others, others_probe

BURN = [sys.executable, "-I", "-c", "while True: pass"]


def test_own_processes_are_none_of_the_others():
    own: set[tuple[int, int]] = set()
    with subprocess.Popen(BURN) as child:
        try:
            others = of_others(own)
        finally:
            child.kill()
    numbers = {number for number, _ in others}
    assert not {child.pid, os.getpid()} & numbers
    assert os.getppid() in numbers
    assert {child.pid, os.getpid()} <= {number for number, _ in own}


def test_a_process_without_a_parent_is_another():
    line = f"'{sys.executable}' -I -c 'while True: pass' >/dev/null & echo $!"
    orphan = int(subprocess.check_output(["sh", "-c", line], text=True))
    try:
        probe = OthersProbe()
        time.sleep(0.5)
        assert orphan in {number for number, _ in of_others(set())}
        assert probe.worst() > 0.1
    finally:
        os.kill(orphan, signal.SIGKILL)


def test_what_fails_three_times_by_its_own_load_fails():
    with subprocess.Popen(BURN) as child:
        try:
            with pytest.raises(pytest.fail.Exception, match="failed 3 times"):
                timed(lambda _: time.sleep(0.1) or "slow", tolerates=99.0, probing=others_probe)
        finally:
            child.kill()
