"""The loop goes on without the process that shakes hands, and says at its end that it was gone."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from tests.support.link.processes import NAMES, Listener, free_ports, link_of, station

DOOR = b"cosim.link.session.process"


def door_of(process: int) -> int:
    """The number of the child that shakes hands."""
    waiting = [process]
    for number in waiting:
        if DOOR in Path(f"/proc/{number}/cmdline").read_bytes():
            return number
        for children in Path(f"/proc/{number}/task").glob("*/children"):
            waiting += map(int, children.read_text().split())
    raise AssertionError(waiting)


@pytest.mark.slow
def test_it_runs_on_and_says_so(tmp_path) -> None:
    ports = free_ports()
    listeners = [Listener(station(name, ports, tmp_path, "--duration", "60")) for name in NAMES]
    while not all(any("connected" in word for word in each.words) for each in listeners):
        assert all(each.process.poll() is None for each in listeners)
        time.sleep(0.01)
    # Past the start, which is agreed on a second ahead.
    time.sleep(2.5)
    os.kill(door_of(listeners[0].process.pid), signal.SIGKILL)
    time.sleep(0.2)
    for each in listeners:
        assert each.process.poll() is None
        assert each.stop() == 1
    said = ["".join(each.words) for each in listeners]
    assert "the process that shakes hands had ended" in said[0]
    assert "the process that shakes hands had ended" not in said[1]
    answered = [link_of(tmp_path / name)["handshake_process"]["answered"] for name in NAMES]
    assert answered == [False, True]
