"""Loops that start together take different processors, and a claim ends with its process."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from cosim.base.system import processors

pytestmark = pytest.mark.skipif(os.name != "posix", reason="claims are file locks")

HOLD = """
import sys
from pathlib import Path
from cosim.base.system.processors import claim
print(claim([0, 1], Path(sys.argv[1])), flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _released():
    yield
    processors.release()


def test_two_processes_never_get_the_same_one_and_a_third_gets_none(tmp_path):
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        theirs = int(other.stdout.readline())
        mine = processors.claim([0, 1], tmp_path)
        assert {theirs, mine} == {0, 1}
        assert processors.claim([0, 1], tmp_path) is None
        other.kill()
        other.communicate()
    assert processors.claim([0, 1], tmp_path) == theirs


def test_the_least_used_one_is_preferred(tmp_path, monkeypatch):
    monkeypatch.setattr(processors, "_use", lambda: {0: 0.7, 1: 0.9, 2: 0.1, 3: 0.1})
    assert [processors.claim(range(4), tmp_path) for _ in range(5)] == [3, 2, 0, 1, None]


def test_a_folder_that_cannot_be_written_claims_nothing_and_stops_nobody(tmp_path):
    assert processors.claim([0], tmp_path / "absent") == 0
    assert processors.claim([0], tmp_path / "absent") == 0
